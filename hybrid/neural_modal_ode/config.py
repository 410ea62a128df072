"""Numbers of the Neural Modal ODE beside those of `hybrid.config`, which are chosen; with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class EncoderConfig:
    """The linear encoder's spread."""

    # of the initial state, relative to the samples' size: a standard deviation of 5 %, so that early draws are useful
    initial_log_variance: float = -6.0
    min_size: float = 1e-3  # rms of the samples, relative to their channels: keeps the logarithm of silence finite


@dataclass(frozen=True)
class DynamicsConfig:
    """The structure's own effects in the latent equations."""

    # rad: largest step times rate of an effect's force; at 1 the explicit propagator is at its limit of stability
    max_phase_per_step: float = 0.25


@dataclass(frozen=True)
class BackboneResidualConfig:
    """Backbone curves over the size of the motion."""

    levels: int = 4  # of size, between which the curves are straight
    # 1/s a unit of the table: 280 steps of Adam at 1e-3 then bend a curve by some 0.1 Hz, as the bridge's do
    rate_per_unit: float = 3.0
    min_mean_square: float = 1e-12  # of a scaled state, near one: keeps the logarithm of rest finite
    size_quantiles: tuple[float, float] = (0.03, 0.95)  # of the windows' sizes, which the levels span
    decay_decades: float = 0.3  # below the lower one: a window's motion halves before it ends


ENCODER = EncoderConfig()
DYNAMICS = DynamicsConfig()
BACKBONE_RESIDUAL = BackboneResidualConfig()
