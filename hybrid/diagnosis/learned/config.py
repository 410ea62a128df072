"""Numbers of what a hybrid model learns on top of a diagnosis, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LearningConfig:
    """Initial states of test recordings, and learned forces held against laws."""

    # of the mean over a state's entries: few recordings may hardly move one that others do
    min_variance_share: float = 0.1
    rank_tolerance: float = 1e-10  # of the largest singular value: laws that are the same over a motion


LEARNING = LearningConfig()
