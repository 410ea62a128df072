"""Numbers of a fit and of its forecasts, with the reason beside each."""

from dataclasses import dataclass

from hybrid.levenberg_marquardt import Damping

FIT_DAMPING = Damping(first=1e-3, easing=30.0, tightening=30.0, most=1e3, free=1e-10)
STATE_DAMPING = Damping(first=1e-3, easing=10.0, tightening=10.0)


@dataclass(frozen=True)
class CalibrationConfig:
    """How far nominal values may be calibrated."""

    max_deviation_sigma: float = 2.5  # of its stated standard deviations: how far a nominal value may be calibrated
    # structures: in which chance has one calibrated factor as far off as `farthest_of`
    structures_per_false_alarm: int = 200
    max_joint_sigma: float = 3.0  # standard deviations of the mean square of all of them over its mean


@dataclass(frozen=True)
class LinearisationConfig:
    """Slopes of recordings by finite differences."""

    # of a prior width (of the rms of a state): finite differences, through thousands of radians
    difference_step: float = 1e-6
    # of each column of the initial state's Jacobian: what no sensor feels apart from the rest stays at rest
    ridge: float = 1e-6
    # of the largest column: what no sensor feels at all, but for rounding; it stays at rest
    unobserved_share: float = 1e-11
    max_channel_sigma: float = 1e30  # of a channel, in units of its noise: no structure, but a search gone astray
    max_residual_ratio: float = 1e6  # times the largest datum: the same, of what a motion under force laws leaves
    least_state: float = 1e-12  # of a state's rms, where it is at rest


@dataclass(frozen=True)
class LeastSquaresConfig:
    """The search for the best parameters of a hypothesis."""

    max_iterations: int = 12
    max_law_iterations: int = 8  # with force laws, each of which takes a simulation of all variants
    # the fall in the sum of squares (a chi-square) below which a fit has converged, for each of noise's own
    min_chi2_fall: float = 0.05
    # of force laws, one after the other, where the motion from the start grows for ever
    law_strengths: tuple[float, float, float] = (1.0, 0.5, 0.2)
    first_steps: int = 1  # after which it shows whether more are worth it
    first_law_steps: int = 2  # likewise: a law's initial states must leave those of the motion without it
    # steps until it shows whether a start that is far off leads low: a second one may still be short
    conclusive_steps: int = 5
    max_cost_ratio: float = 0.5  # of the cost: without a law a step that leaves less is followed by another one
    # share of the cost: a law whose last step took as much away starts far off, and goes on
    steep_fall_share: float = 0.2
    newton_steps: int = 3  # steps of Newton's method in which initial states follow a law that comes, goes or changes
    # none at first: a cause and the uncertain factor it resembles need whole steps; more where such a step fails
    damping: Damping = FIT_DAMPING


@dataclass(frozen=True)
class InitialStateConfig:
    """Initial states of recordings that were not fitted."""

    # of the stretch, where force laws act: so that the search begins near
    stretch_shares: tuple[float, ...] = (0.15, 0.25, 0.35, 0.5, 0.7, 1.0)
    max_iterations: int = 20  # at most, of each
    damping: Damping = STATE_DAMPING
    min_gain: float = 0.01  # of a sum of squares in units of the noise: a step that promises less is not taken
    max_motion_ratio: float = 1e6  # times the largest value recorded: what stands for a motion beyond all bounds
    difference_step: float = 1e-4  # of a state's prior standard deviation


@dataclass(frozen=True)
class ForecastConfig:
    """Forecasts, and what a perfect model would score."""

    estimation_share: float = 0.2  # of each recording: what its initial state is estimated from
    order_cost: float = 6.0  # in a cost: 2 log 20, as one of twenty recordings is not as those before and after it are
    # likewise: what geometry must take off a cost, where recordings for training do not show it
    min_geometry_gain: float = 6.0
    geometry_rounds: int = 3  # of taking away what geometry adds to a motion, which shows what it adds
    # of new initial states: that share of either side lies within what is known of them beforehand
    initial_state_quantile: float = 0.99
    max_error_sigma: float = 3.0  # standard deviations of what errors are by chance
    least_state_share: float = 1e-6  # of the largest initial state of its unit: what is known of each beforehand
    # places of a segment, evenly spread: of ten segments of three recordings enough to find the farthest
    states_per_segment: int = 40
    # groups of recordings, each forecast by the fit to the others; every fold costs a fit of each model
    max_folds: int = 4
    fold_iterations: int = 4  # of a fit that begins at the one of all recordings


@dataclass(frozen=True)
class GeometryResponseConfig:
    """Motions that geometry adds to linear ones."""

    max_rounds: int = 12  # at most, of taking forces along a motion: enough where they turn a mode by three radians
    # of the forces: what the last round may still change of them, and a tenth of that of the motion
    max_relative_change: float = 0.01
    # times the sampling rate: how often forces are sampled, which go with three times the highest frequency
    oversampling: int = 2
    # degree of splines whose derivatives are taken: right to 0.1 % up to 0.3 of the sampling rate, ends apart
    spline_degree: int = 5
    # of noise's energy: where geometry adds less than that, or less more, it stays as it is
    min_energy_share: float = 0.01


@dataclass(frozen=True)
class HarmonicConfig:
    """In which recordings a harmonic force acts."""

    # of the usual amplitude: less is a recording without the force, if the difference is certain
    absent_share: float = 0.4
    min_difference_sigma: float = 4.0  # standard deviations
    # standard deviations: an amplitude below that is distinguished from none by nothing that the force itself does
    min_amplitude_sigma: float = 2.0


CALIBRATION = CalibrationConfig()
LINEARISATION = LinearisationConfig()
LEAST_SQUARES = LeastSquaresConfig()
INITIAL_STATES = InitialStateConfig()
FORECAST = ForecastConfig()
GEOMETRY_RESPONSE = GeometryResponseConfig()
HARMONIC = HarmonicConfig()
