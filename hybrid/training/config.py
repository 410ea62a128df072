"""Numbers of training that no user chooses, with the reason beside each; what can be chosen is in `hybrid.config`."""

from dataclasses import dataclass


@dataclass(frozen=True)
class GaussNewtonConfig:
    """Training of residuals tied to places."""

    std_over_median: float = 1.4826  # of the absolute values of normal noise
    # of the largest entry: a parameter that nothing depends on yet is damped all the same
    least_diagonal_share: float = 1e-3
    max_tries: int = 6  # steps in a row that do not lead down
    prior_precision: float = 0.1  # of each parameter, near one: a net's weights wander where data do not determine them
    state_refinements: int = 2  # Gauss-Newton steps of the initial states after each change of the parameters
    outlier_ratio: float = 2.0  # times the median misfit: windows beyond count less and less
    horizon_growth: int = 2  # of the horizon, once a step gains too little
    min_relative_gain: float = 0.01  # of the cost; at the whole length the end of the training
    growing_share: float = 0.5  # of the epochs: after it the horizon of windows under known forces is the whole length
    own_noise_share: float = 0.25  # of the whole length: from horizons beyond on, each channel has its own noise
    # misfit a sample (half a square of noise deviations; about 0.5 is right): numbers near overflow
    max_misfit_per_sample: float = 1e8
    least_spread_share: float = 1e-4  # of the mean variance: keeps a prior on states that never move


@dataclass(frozen=True)
class GradientConfig:
    """Training by Adam."""

    max_gradient_norm: float = 10.0  # longer gradients are shortened to this: rare, after a draw of z0 far out
    last_learning_rate_share: float = 0.05  # of the first; a cosine leads there
    least_noise_share: float = 0.05  # of a channel's rms over all windows: the least noise, relative as the rest of it


@dataclass(frozen=True)
class PreparationConfig:
    """What is prepared before training."""

    max_calibration_windows: int = 200  # at most; evenly chosen, more add time but little information
    # times the encoder's samples: how long the linear model is trusted to estimate noise and spread
    smoothing_span: int = 2
    max_consistency_windows: int = 30  # at most, of each recording
    min_recordings_to_compare: int = 3  # training recordings: of two that disagree nobody knows which to leave out
    least_mode_share: float = 1e-3  # of the strongest mode's size: the least size a mode is scaled with
    max_starts: int = 5000  # at most, of each recording, evenly chosen: 70 times the numbers in a start of the bridge's


GAUSS_NEWTON = GaussNewtonConfig()
GRADIENT = GradientConfig()
PREPARATION = PreparationConfig()
