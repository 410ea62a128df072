"""Numbers of the estimation of states, linear models and uncertainty, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class LinearCalibrationConfig:
    """The linear model that least squares finds."""

    window_shares: tuple[float, ...] = (0.1, 0.2, 0.4, 1.0)  # of the whole window, one after the other
    min_samples: int = 20  # samples; shorter windows show little but noise
    # times the share that the shortest windows leave: longer ones need more than a linear model
    max_unexplained_ratio: float = 1.5
    max_iterations: int = 100  # of L-BFGS at each length; the bridge needs 30 to 80
    # on the initial state, relative to its mean normal-matrix entry: modes the sensors do not see stay at rest
    ridge: float = 1e-4
    # of the error covariance towards a multiple of the identity: it is estimated from few windows
    covariance_shrinkage: float = 0.02
    # of the rms of all windows: added to a window's own rms, so that noise in quiet windows does not count
    quiet_share: float = 0.05
    # on squared off-diagonal entries, relative to omega: keeps the shapes near the model's
    coupling_penalty: float = 1e-2
    diagonal_penalty: float = 1e-5  # frequencies and damping ratios are free: 1e-5 only fixes those that no sensor sees


@dataclass(frozen=True)
class StateConfig:
    """The most probable initial state of a window."""

    max_step: float = 2.0  # in scaled states, which are near one: keeps the search where the forces are known
    max_iterations: int = 10  # from nothing
    max_iterations_from_near: int = 4  # from a state that is nearly right
    # of the span of samples, one search after the other: a state from few samples starts that from more
    span_growth: float = 3.0
    windows_per_batch: int = 25  # at a time: what one batch needs stays in the processor's cache
    least_square: float = 1e-30  # of x^T V^-1 x: keeps the logarithm of silence finite


@dataclass(frozen=True)
class UncertaintyConfig:
    """Bands about forecasts."""

    windows_per_batch: int = 64  # windows at a time: bounds memory
    # degrees of freedom of the prior on a window's noise: ten samples of four channels weigh twice that
    noise_degrees_of_freedom: int = 20
    draws: int = 50  # of each initial state: the standard deviation is then good to a tenth
    windows_per_draw_batch: int = 10  # at a time: bounds memory
    max_band_windows: int = 100  # training windows at most that estimate the model's own error
    level: float = 0.9  # of what is to be in the band
    min_coverage: float = 0.8  # of test data in the band of `level`: below, the band is too narrow to be used
    level_sigma: float = 1.645  # standard deviations either side of a normal mean
    seed: int = 0  # the same draws for the same prediction


@dataclass(frozen=True)
class WindowConfig:
    """Stretches of a recording that are forecast from their first samples."""

    default_samples: int = 500  # as in the paper
    # a window gives one initial state: as many as the states of ten modes, for an encoder that estimates all of them
    min_windows: int = 20
    # of the shortest recording: a window that is shorter still shows too little of a slow decay
    min_recording_share: float = 0.5


@dataclass(frozen=True)
class SensingConfig:
    """Motion under unknown forces."""

    min_samples: int = 100  # of a recording: with fewer, forces and noise cannot be told apart
    max_samples: int = 4000  # of the stretch from which the sizes of forces and noise are estimated: to some per cent
    linearisations: int = 3  # of a learned model, the first at rest: the third moves states by less than their band
    size_searches: int = 2  # along the first of these: sizes hardly follow the last
    iterations: int = 40  # of the search for these sizes
    log_range: float = 15.0  # of a variance about its start: a factor of three million
    first_noise_share: float = 0.01  # of a channel's energy: where the search for its noise begins
    first_state_ratio: float = 10.0  # times the covariance that forces of the first sizes maintain
    max_spectral_radius: float = 0.9999  # of a step: a model that hardly decays maintains a finite covariance then
    doublings: int = 20  # of the steps that are summed for it: a million
    states_at_once: int = 2000  # whose steps are computed together: bounds memory


LINEAR_CALIBRATION = LinearCalibrationConfig()
STATE = StateConfig()
UNCERTAINTY = UncertaintyConfig()
WINDOWS = WindowConfig()
SENSING = SensingConfig()
