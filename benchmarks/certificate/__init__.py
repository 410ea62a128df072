"""The certificate: how often a diagnosis is right, at one commit, over blind cases that nobody looks into.

Its seeds are for this alone. What it misses is counted and never studied, so that the rates stay an honest measure of
the code that ran. Cases are kept one by one, so that a run may be interrupted and go on.
"""
