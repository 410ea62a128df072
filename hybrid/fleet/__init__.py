"""Many tasks at once: datasets that are diagnosed, blind cases that are judged.

`engine` does the tasks that nobody has done yet and keeps each result as soon as it is there; `processes` and `cluster`
are two places where the work goes on. What is done is a function of a task alone, both of which can be pickled. On top
stands the fleet of diagnoses: `datasets` says of what, `case` diagnoses one, `rows` keeps the answers, `table` shows
them, `run` joins these.
"""
