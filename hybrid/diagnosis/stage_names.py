"""The stages of a diagnosis, which goes through all of them in turn; most are soon over where little is wrong.

Light to load, so that a bar shows how many there are before the search itself is loaded.
"""

SEARCH = (
    "causes in some recordings only",
    "places next to those found",
    "causes in all recordings",
    "two causes at once",
    "what is promised beside them",
    "groups of recordings",
    "places that look alike",
    "each cause alone",
    "the best once more",
)
"""Beyond single causes, in the order of `contest.evidence.STAGES`."""
SERIES_STAGES = ("recordings", "single causes", *SEARCH, "forecasts")
"""Of a diagnosis by time series."""
MODAL_CAUSES = ("the first cause", "a second cause", "a third cause")
MODAL_STAGES = (
    "modes of the recordings",
    "nominal values",
    "changes between recordings",
    *MODAL_CAUSES,
    "other causes in their place",
    "force laws",
    "forecasts by modes",
)
"""Of a diagnosis by modes and motion."""
STAGE_NAMES = (*MODAL_STAGES, *SERIES_STAGES)
