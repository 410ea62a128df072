"""Numbers of the modal evidence, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PairingConfig:
    """Which measured mode is which of a structure's."""

    # a frequency that far off costs as much as a MAC lower by that; both are what models off by a fifth have
    frequency_scale: float = 0.05  # of the logarithm
    mac_scale: float = 0.05
    max_frequency_difference: float = 0.3  # of the logarithm: farther off no pair is made
    min_mac: float = 0.5  # below, another mode is as like
    # of its largest entry: a shape that moves less where the structure's mode moves most is of another, or a sensor's
    # that fails, and cannot be taken over that entry
    min_reference: float = 0.03
    max_cost: float = 40.0  # of both together: a frequency off by 30 %, or a MAC of 0.5, with little of the other


@dataclass(frozen=True)
class CombinationConfig:
    """Lines of a recording at sums, differences and multiples of frequencies: a nonlinear motion, no modes."""

    max_relative_distance: float = 2e-3  # of its frequency, or four standard deviations, how far such a line may be off
    max_distance_sigma: float = 4.0
    max_energy_share: float = 0.02  # of either mode that it is made of; a mode of its own is seldom so weak and there


@dataclass(frozen=True)
class ListedConfig:
    """Modes that somebody else identified: what is usual where a standard deviation was not given."""

    frequency_error: float = 2e-3  # of the frequency
    ratio_error: float = 0.2  # of the damping ratio
    shape_error: float = 0.03  # of the largest entry
    unknown_ratio: float = 0.01  # where none was identified, with ...
    any_ratio: float = 1.0  # ... a standard deviation that says nothing
    any_shape: float = 1e2
    samples_a_cycle: float = 4.0  # of the highest mode: the structure is followed up to twice its frequency


@dataclass(frozen=True)
class UnpairedConfig:
    """Measured modes that no mode of the structure is: so wide is what they might have been."""

    log_frequency: float = 0.1
    damping_ratio: float = 0.01
    shape: float = 0.5  # of the largest entry
    probability: float = 0.1  # of a measured mode, beforehand


@dataclass(frozen=True)
class InflationConfig:
    """Measured modes whose identification errs by more than it says."""

    degrees: float = 4.0  # of freedom of Student's distribution: beyond four times their size are 1.6 % of errors
    max_variance_factor: float = 1e4
    steps: int = 41  # of the logarithm of that factor, from one on


@dataclass(frozen=True)
class FitConfig:
    """The best factors and sizes of a claim."""

    max_iterations: int = 10
    null_iterations: int = 14  # of the first fit, whose nominal values come from farthest
    null_starts: int = 12  # beside that from the drawn values, ...
    start_spread: float = 0.15  # ... as far off, of factors' logarithms, as values of drawings may be, ...
    element_scales: tuple[float, ...] = (1.0, 30.0)  # in turn: the search for sizes stays near where it begins
    null_agreeing: int = 3  # ... until so many lead to the best, ...
    same_nats: float = 1.0  # ... or as near to it; and as good with the modes of a nearer structure as basis
    difference_step: float = 1e-5  # of a prior standard deviation: modes change by 1e-7 of themselves
    max_log_step: float = 0.3  # of a factor's logarithm in one step
    converged_log_step: float = 1e-3
    converged_sigma: float = 0.05  # of a size: a smaller step changes no answer
    error_iterations: int = 8  # of the search for the sizes of errors, in each round
    bound_approach: float = 0.5  # of the way to a bound that a step would cross
    max_basis_shift: float = 0.05  # of a factor's logarithm: beyond it the modes of another structure serve as basis
    max_rebased: int = 3


@dataclass(frozen=True)
class ClaimScanConfig:
    """Which claims are worth a fit."""

    # prior standard deviations from doing nothing at which a cause is tried; a step of least squares goes on from each
    sizes: tuple[float, ...] = (-2.0, -0.6, -0.2, 0.02, 0.07, 0.2, 0.6, 2.0)
    # of an unknown change of the structure: what a scan leaves of it, for what is not linear in causes
    remaining_change: float = 0.03
    # of what nominal values gain that are off: what one cause must promise that they may stand for; scans are rough
    min_share: float = 0.5
    # claims of each scan that are fitted for a few rounds: those that promise this share of what the best does, as one
    # may gain three times what is promised, or a third, where nominal values are far off, ...
    min_promise: float = 0.3
    max_polished: int = 40  # ... at most: a quarter of a minute's work, ...
    polishing_rounds: int = 8  # ... each with so many, as values that are off by a fifth are far to go
    max_fitted: int = 4  # ... and those of them that are fitted whole
    max_kept: int = 2  # claims that the next cause is added to, ...
    beam_nats: float = 30.0  # ... but none that is so far behind: what it lacks, another cause would have to bring, too
    further_probability: float = 0.1  # beforehand, of another cause beside one: groups' factors are fitted anyway
    max_moves: int = 3  # times that causes are exchanged for others, as long as it is the better for it
    min_gain: float = 0.0  # of the log posterior: what a further cause must bring


@dataclass(frozen=True)
class UnsureSizesConfig:
    """How far the sizes of errors may be from the most likely ones."""

    draws: int = 32  # of sizes: standard deviations to some per cent
    # of factors' logarithms, one standard deviation: a drawing that is farther off is of another structure
    max_deviation: float = 0.5
    between: int = 4  # steps from one draw to the next, by which they hardly hang together
    difference_step: float = 0.05  # of a size's logarithm


@dataclass(frozen=True)
class ConclusionConfig:
    """What is reported of the best claims."""

    normal_sigma: float = 3.0  # stated standard deviations: as far off as values of a few dozen are by chance
    min_probability: float = 0.9  # that a group is farther off than that, from which on it is a finding
    even: float = 0.5  # ... beside something unknown, which may move the same modes
    max_left_of_explained: float = 0.1  # of the drawn structure's misfit: ten times better is explained
    max_left_of_part: float = 0.5
    max_usual_frequency: float = 3.0  # times the usual error of right models
    min_paired: float = 0.5  # of the measured modes: a structure that has fewer is not one that is right
    refitted: int = 8  # claims that are held against modes that something unknown moves, too
    # times a frequency's usual error, which identification leaves and recordings vary by: no right one is so far off
    doubted_sigma: float = 4.0


PAIRING = PairingConfig()
COMBINATION = CombinationConfig()
LISTED = ListedConfig()
UNPAIRED = UnpairedConfig()
INFLATION = InflationConfig()
FIT = FitConfig()
CLAIM_SCAN = ClaimScanConfig()
UNSURE_SIZES = UnsureSizesConfig()
CONCLUSION = ConclusionConfig()
