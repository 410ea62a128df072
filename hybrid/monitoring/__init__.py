"""A structure watched: recordings that come in, held against its history, and an alarm when its state changes.

`station` says what is watched, `observation` what is kept of each recording, `tracked_modes` which mode of one is which
of another, `control_chart` whether a recording is as usual, `watching` joins these; `charts` and `page` show them.
"""
