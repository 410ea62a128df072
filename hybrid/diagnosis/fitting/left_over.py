"""What a fit leaves of the recordings beyond noise."""

from hybrid.diagnosis.fitting.fitting import Fit
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.recorded.noise import Band, Excess, excess


def left(item: Fit, gauge: Gauge, band: Band) -> Excess:
    """Return what a fit leaves in the structure's band beyond noise."""
    return excess(item.residuals, gauge.rate, band)
