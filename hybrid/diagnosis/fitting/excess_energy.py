"""What a fit leaves of the recordings beyond noise."""

from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.recorded.noise import Band, Excess, excess
from hybrid.diagnosis.recorded.noise_model import NoiseModel


def excess_energy(item: Fit, noise_model: NoiseModel, band: Band) -> Excess:
    """Return what a fit leaves in the structure's band beyond noise."""
    return excess(item.residuals, noise_model.rate, band)
