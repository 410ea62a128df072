"""What a simulation gets wrong, and why.

In the order of its folders, each of which imports from those before it alone: the structure as drawn and the candidates
for causes in it (`nominal`), the recordings (`recorded`), what a cause makes the sensors show (`response`), the fit of
one (`fitting`), a quick look at all (`screening`), the contest among the promising (`contest`), that by modes, which
needs no nearly right model (`modal`), and what would tell rivals apart (`next_measurement`); then what is reported:
what was wrong before any cause (`observed`), what follows (`outcome`), what a net has left to learn (`learned`); and a
diagnosis of its own, by what motion shows beyond the modes (`discrepancy`) and by both (`modes_and_motion`).
`diagnosis` runs it all, `report` writes it down, and how often answers like it were right is known from the
certificate (`track_record`).
"""
