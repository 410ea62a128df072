"""Numbers of the monitoring, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class MonitoringConfig:
    """When a structure is as usual, and when an alarm is raised."""

    # of recordings of a structure that did not change: one in 370, as of Shewhart's limits of three standard deviations
    false_alarms: float = 0.0027
    least_history: int = 5  # recordings, before any is judged: of fewer, limits are too wide to be of use
    min_seen: float = 0.8  # share of the history in which a mode is seen that has a chart; others come and go
    most_modes: int = 12  # that have a chart, the strongest
    # of the modes that all of the history shows, missing in a recording: more, and it is of another structure
    most_lost: float = 0.5
    # of the energy, in every recording of the history: accelerations hold little more of a lowest mode, noise less
    strong_share: float = 0.01
    same_factor: float = 0.02  # relative: frequencies that differ from the usual by one factor, as of a wrong rate
    before: int = 3  # recordings of the usual state, the last ones, beside which a changed one is diagnosed


MONITORING = MonitoringConfig()
