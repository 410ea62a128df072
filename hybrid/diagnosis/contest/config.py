"""Numbers of the contest of causes over time series, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class NoiseLevelConfig:
    """What the contest takes for noise, and when it is sure of that."""

    # over the noise floor: mean and largest error of forecasts in which no cause would show
    max_clean_ratios: tuple[float, float] = (1.02, 1.1)
    max_clean_energy_ratio: float = 1.05  # energy that a fit leaves over that of noise, in which no cause would show
    # of the noise that recordings tell themselves, how far it may be estimated anew: harmonics of what is wrong, which
    # the nominal model leaves under known forces at all frequencies, are taken for ten times as much
    new_ratios: tuple[float, float] = (0.1, 1.5)
    max_share_left: float = 1e-3  # of what the nominal model leaves: a fit that leaves less shows the noise
    # energy left over that of noise: 0.3 of that of the motion where noise is 1 % of its amplitude; one cause, however
    # large, leaves less than 0.2 of it in short segments whose initial states are free
    astray_ratio: float = 3e3
    rounds: int = 3  # of taking the noise from the fit, which takes it from the noise
    max_geometry_passes: int = 3  # along another motion: the best fit changes once or never
    geometry_seed: int = 0  # of the states at which geometric forces are taken: the same of the same recordings


@dataclass(frozen=True)
class ShortlistConfig:
    """How many candidates of a screening are fitted."""

    kept: int = 10  # from the screening of each length
    kept_of_group: int = 6  # likewise, of some of the recordings: all have been searched before
    kept_laws: int = (
        5  # force laws at most, of a screening's and of those after their first steps: they take far longer
    )
    scanned_times: int = 4  # as many of a scan, which knows nothing of what the uncertain factors could do besides
    by_modes_times: int = 2  # as many of a ranking by modes, which are seen about a calibration that may be far off
    min_promised_fall: float = 8.0  # in the sum of squares, by the score test; less cannot outweigh the prior odds
    leading: int = 2  # of each ranking of those that start as drawn: a first step from there may tell little
    always_fitted: int = 2  # of each ranking, however little they promise
    foremost: int = 16  # of all without a force law, after their first step: a large effect may need some more to show
    foremost_drawn: int = 8  # besides, of those that start as drawn, where all else that is off shows, too
    tied_fall: float = (
        10.0  # in the sum of squares, of values that each tell as much as one: what comes next may decide
    )
    max_tied: int = 16  # of those that near the best
    # beside a force law, where first steps take a second each; in blind frames the one that ends best has been the
    # first or second of its kind
    max_first_of_a_kind: int = 8
    max_of_a_kind: int = 3  # of force laws, and of all that go on beside one: they look alike at all places near
    max_promising: int = 4  # causes that are fitted to whole recordings because a score test promises something of them


@dataclass(frozen=True)
class SegmentConfig:
    """Fits over ever longer segments of the recordings, and which of them go on."""

    pieces: tuple[int, ...] = (10, 3, 1)  # that recordings are cut into, in turn: short ones forgive a wrong start
    min_values_per_state: int = 8  # of a segment, for each entry of its initial state
    first_force: float = 1e-3  # N: where the search for a harmonic force begins
    enough_fall: float = 1.0  # in the sum of squares, at which fits of segments stop; they are only starts
    first_drawn_steps: int = 3  # from the structure as drawn: the first ones mend all that is off besides
    short_iterations: int = 8  # of the fits of the shortest segments
    racing: int = 5  # fits that go on, if no more are near the best that have no force law
    racing_laws: int = 3  # of them beside a force law, where each takes far longer
    racing_promising: int = 2  # that go on however far behind, where whole recordings promise more of them
    given_up_behind: float = 20.0  # in half the tempered sum of squares, behind another of the same recordings
    max_behind_share: float = 0.3  # of what the best leaves beyond noise: by how much another may be behind and go on


@dataclass(frozen=True)
class StageConfig:
    """When a stage of the search has something to do."""

    max_law_share: float = 0.8  # of the misfit: a law that leaves more has no change beside it
    max_faint_sigma: float = 2.0  # standard deviations of what noise alone leaves
    min_unlike_ratio: float = 1.2  # of mean squares that show a change between recordings ...
    max_unlike_chance: float = 1 / 700  # ... if white noise has one so far off more rarely: 3.2 standard deviations
    # over the noise floor: mean and largest error of forecasts in which a second cause would not show
    max_good_ratios: tuple[float, float] = (1.05, 1.25)


@dataclass(frozen=True)
class NeighbourConfig:
    """Places beside the best one."""

    max_steps: int = 4  # from place to place
    as_good_nats: float = 3.0  # of tempered log evidence, less than the best: places that recordings do not distinguish
    max_fits: int = 12  # at them, after which it spreads no further: a tower has as many nodes
    max_noise_ratio: float = 1.1  # times the energy of noise: a law at its right place hardly leaves it of segments
    max_left_share: float = 0.5  # of what is wrong: beyond, places are guesses; friction three nodes off leaves 0.25


@dataclass(frozen=True)
class PairConfig:
    """Two causes at once."""

    min_second_nats: float = 10.0  # of tempered log evidence, by the second: then the first is looked for again
    max_sorted_share: float = 0.02  # of the misfit: so little left, a cause in some recordings may be the only one
    # likewise, of one: where the best cause leaves more, a second one would only add to the guess; a cable as good as
    # gone leaves 0.71 beside friction
    max_single_share: float = 0.8
    max_pair_share: float = 0.3  # likewise, of two: the best of them leave so much that neither is likely right
    # energy left over that of noise: right causes of blind frames leave 1.2 to 1.3, a stop without the late sensor
    # beside it 2
    max_left_ratio: float = 1.5
    max_halved_share: float = 0.5  # of what the first of two leaves: where both leave less, the first may be a guess
    max_firsts: int = 2  # single causes that a second one is looked for
    max_rivals: int = 8  # candidates that are tried in the place of one of two causes
    max_found_alone: int = 3  # causes that begin beside a force law as they ended alone


@dataclass(frozen=True)
class HarmonicSearchConfig:
    """Harmonic forces of unknown frequency."""

    # in the sum of squares, for each recording: its two entries of the initial state cost as much
    min_fall_per_recording: float = 5.0
    max_fitted: int = 3
    neighbours: int = 10  # of a frame, where they are alike: if a harmonic force is the best of all
    max_neighbours: int = 30  # where they promise as much as the first: the nodes of a tower that has one sensor
    underrated: float = 2.0  # how much more one may explain than it promises, once its frequency is refined
    min_lines_apart: float = 2.0  # of a recording's resolution: frequencies that near are one


@dataclass(frozen=True)
class GroupConfig:
    """Recordings in which a cause acts, and others."""

    min_recordings: int = 3  # in which two groups can be told
    tried: int = 4  # candidates, the most promising if each recording had its own amount
    tried_laws: int = 2  # of them force laws
    min_felt_share: float = (
        1e-3  # of the most that a recording feels of a cause: less cannot tell whether it acts there
    )
    min_clear_share: float = 0.2  # see `clear_share`
    # of all orders of the recordings, in which a change may be as clear as in theirs; of six, three before and three
    # after it are so in one of ten
    max_chance: float = 0.11
    orders: int = 1000
    seed: int = 0
    rounding: float = 1e-9
    alike_nats: float = 20.0  # of log evidence: what some of the recordings cannot tell apart all of them may
    max_alike: int = 3  # of these
    max_within_share: float = 0.4  # of the variance: beyond, they are one group to a force law, whose fits take long
    # of a chain's misfit over short segments, by the best: where something else is wrong it promises 0.05 to 0.2. Of a
    # frame, whose calibration goes further astray, the right one may promise as little
    min_promised_share: float = 0.2
    max_noise_sigma: float = 3.0  # of noise's sum of squares: a misfit may be as large without anything wrong
    sorting_rounds: int = 3  # of sorting the recordings by the fit and fitting again
    endless: float = 1e12  # a sum of squares beyond all that is compared, of motions that explode


@dataclass(frozen=True)
class WrongUnitConfig:
    """Sensors whose unit is another than stated."""

    min_ratio: float = 4.0  # times or a part of the truth: no calibration is as far off
    max_left_share: float = 0.1  # of what the others leave with it: what they leave of themselves without such a sensor


NOISE_LEVEL = NoiseLevelConfig()
SHORTLIST = ShortlistConfig()
SEGMENTS = SegmentConfig()
STAGE = StageConfig()
NEIGHBOURS = NeighbourConfig()
PAIRS = PairConfig()
HARMONIC_SEARCH = HarmonicSearchConfig()
GROUPS = GroupConfig()
WRONG_UNIT = WrongUnitConfig()
