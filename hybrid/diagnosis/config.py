"""Numbers of a diagnosis as a whole, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class ThreadConfig:
    """Threads of a diagnosis."""

    linear_algebra: int = 1  # the matrices are small, and more threads only wait for each other
    motions: int = 2  # under force laws, each of which holds a core only while it works


@dataclass(frozen=True)
class ReportConfig:
    """What a report says, and what it leaves out."""

    min_named_probability: float = 0.5  # of a cause that a headline calls named
    max_rivals_listed: int = 5  # of a finding, on the terminal
    max_places_listed: int = 8  # at which a finding of the same kind would do as well, on the terminal
    max_learned_places_listed: int = 3  # where most was learned, on the terminal
    min_explained_share: float = 0.005  # of what was wrong: what less a finding takes away of it is reported as none
    min_factor_change: float = 1e-4  # a smaller change of an uncertain factor is not worth a line


@dataclass(frozen=True)
class SearchChoiceConfig:
    """Which search goes first, by series or by modes, and whether its answer is enough."""

    far_groups: int = 2  # of elements surely off by more than was stated: one may stand for a local cause
    sure_probability: float = 0.9  # of each finding of an answer that leaves nothing open


THREADS = ThreadConfig()
REPORT = ReportConfig()
SEARCH_CHOICE = SearchChoiceConfig()
