"""Numbers of the evidence over time, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class DiscrepancyConfig:
    """How motion may differ from what a structure does by itself, and how that is followed."""

    parts: int = 4  # of a time step, in which forces are evaluated: a hundred a cycle where ten samples are
    min_size: float = 3e-4  # sizes of the discrepancy that are told from nothing, ...
    max_size: float = 0.3  # ... and from a motion that no model has
    usual_start: float = 1e-2  # of either part, from where the most probable are sought, ...
    factors: tuple[float, ...] = (3.0, 1.7)  # ... by steps of an octave and a half, then of half as much
    shrinking: float = 0.5  # ... and of both parts, beside all that modes may be, as long as less is more probable
    loose_size: float = 0.1  # where modes go their own way, as their amplitudes are found, ...
    loose_share: float = 3e-2
    passes: int = 4  # ... each time with those found before
    initial_amplitude: float = 10.0  # times that of the motion: nothing is known of initial states
    min_amplitude: float = 1e-8  # of the strongest mode's
    # of the discrepancy of a model that is right, over the motion and a radian: some thousandths, as of its frequencies
    usual_size: float = 2e-3
    usual_spread: float = 1.2  # of its logarithm, as of other errors of models
    # that what is wrong is none of the list's laws, over that it is one of them: the list has what engineers look for
    odds_off_list: float = 0.2
    odds_unknown: float = 0.5  # of something that changes with amplitude or time and has no name, in any structure


@dataclass(frozen=True)
class LawFitConfig:
    """The best parameters of a force law."""

    steps: int = 4  # for each estimate of the motion
    difference_step: float = 1e-3  # of a prior standard deviation
    first_damping: float = 1e-3  # of Levenberg's and Marquardt's steps
    tries: int = 4  # each ten times shorter: then none helps
    converged_nats: float = 0.05  # a step that gains less changes no answer
    rounds: int = 16  # motion and parameters in turn, ...
    first_rounds: int = 4  # ... and after how many of them laws are compared
    # samples, times modes and sensors, that laws are sought in: half a minute's work; more where one is named
    max_values: float = 2e5
    easing: float = 0.5  # of how much of the new motion is taken, where a round fails, ...
    min_share: float = 0.05  # ... until so little is taken that nothing more is to be had
    shrinking: tuple[float, ...] = (0.3, 0.6, 1.0)  # of the discrepancy's size, from one round to the next
    settled_nats: float = 0.5  # gained in a round
    settled_share: float = 0.01  # of all that a law has gained
    # between the modes' motions at two places, from which on one stands for both in a scan
    min_cosine: float = 0.95
    max_fitted: int = 12  # laws of a scan, along the motion as it is, ...
    max_refined: int = 3  # ... and of these with their own motion
    max_neighbours: int = 4  # of the best law's place that are tried beside it, ...
    max_moves: int = 3  # ... as often as one of them is better
    max_settled: int = 2  # of all, the best and its rival, whose modes are moved to where the recordings have them
    # of what a law does to modes: as little is its force known along a motion that noise makes turn now and then
    relative_error: float = 0.05


@dataclass(frozen=True)
class SettlingConfig:
    """Modes that are moved to where recordings have them."""

    steps: int = 8  # Newton's, of which a handful is enough where phases are not off by whole turns
    easing: float = 0.5  # of a step that fails, ...
    min_share: float = 0.1  # ... until so little is left that nothing more is to be had
    factors: tuple[float, ...] = (1.7,)  # of the discrepancy, from one step to the next
    settled_nats: float = 0.5  # gained by a step
    max_whole: float = 3e-2  # discrepancy beyond which phases are lost within thirty radians, and say little of modes
    turns: int = 3  # of a law and the modes beside it


DISCREPANCY = DiscrepancyConfig()
LAW_FIT = LawFitConfig()
SETTLING = SettlingConfig()
