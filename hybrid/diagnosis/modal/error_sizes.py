"""How far off a model's modes are where all its values are right, and how far nominal values are off: both estimated.

Every model leaves something out. What it leaves shifts each mode's frequency, damping and shape by amounts that are the
same in all recordings; from one recording to the next they differ by less. The sizes of both, and the scale by which
nominal values are off beyond what was stated, are parameters of the covariance of all that is measured; they are found
by maximum marginal likelihood (type II), beside broad priors.
"""

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.modal.mode_values import MODE_QUANTITIES

MAX_STATED_SCALE = 3.0  # of what was stated: a drawing whose values are farther off is not what was stated


def _size(median: float, spread: float) -> Any:
    """Return the field of a size by its prior: its median, and the standard deviation of its logarithm."""
    return field(default=median, metadata={"spread": spread})


@dataclass(frozen=True)
class ErrorSizes:
    """Standard deviations of what a right model gets wrong of each mode: of log frequency, damping ratio, and Re and Im
    of a shape's entries (of the reference entry); those that differ from one recording to the next (``_varies``); and
    the scales of the stated uncertainties. The values given are prior medians.
    """

    frequency: float = _size(2e-3, 0.5)  # where all values are right, models agree to thousandths, seldom to 1 % only
    ratio: float = _size(5e-4, 1.2)
    shape: float = _size(1e-2, 1.2)  # a MAC of 0.999; ten times that are 0.95
    phase: float = _size(5e-3, 1.2)
    frequency_varies: float = _size(3e-4, 1.2)  # a degree of temperature, or an amplitude half as large
    ratio_varies: float = _size(2e-4, 1.2)
    shape_varies: float = _size(3e-3, 1.2)
    phase_varies: float = _size(3e-3, 1.2)
    stiffness_scale: float = _size(1.0, 1.5)  # of what was stated; the data may say that it is far more, or less
    mass_scale: float = _size(1.0, 1.5)
    damping_scale: float = _size(1.0, 1.5)
    element_scale: float = _size(1.0, 1.5)
    change: float = _size(1.0, 1.0)  # of the sizes of an unknown change, below

    @property
    def log_prior(self) -> float:
        """The log prior density of the logarithms, but for a constant."""
        off = np.log(self.values) - LOG_MEDIANS
        return -0.5 * float(off @ LOG_PRECISION @ off)

    @property
    def common(self) -> FloatArray:
        """The sizes (quantity,) of errors that a mode has in all recordings, in the order of `MODE_QUANTITIES`."""
        return np.array([getattr(self, name) for name in MODE_QUANTITIES])

    @property
    def varying(self) -> FloatArray:
        """The sizes (quantity,) of what differs from one recording to the next, in the same order."""
        return np.array([getattr(self, f"{name}_varies") for name in MODE_QUANTITIES])

    @property
    def are_usual(self) -> bool:
        """Whether a model whose values are all right may have such errors: none is larger than is usual, but for those
        of damping ratios, which no model has right.
        """
        usual = ErrorSizes()
        names = [name + end for name in MODE_QUANTITIES if name != "ratio" for end in ("", "_varies")]
        return all(getattr(self, name) <= getattr(usual, name) for name in names)

    @property
    def values_are_off(self) -> bool:
        """Whether stiffnesses or masses, of groups or of single elements, are off by more than was stated."""
        return max(self.stiffness_scale, self.mass_scale, self.element_scale) > MAX_STATED_SCALE

    @property
    def as_usual(self) -> "ErrorSizes":
        """The sizes, none of them larger than is usual where all else is right, the scale of single elements included;
        the scales of groups and of an unknown change are as they are.
        """
        usual, kept = ErrorSizes(), ("stiffness_scale", "mass_scale", "damping_scale", "change")
        return ErrorSizes(**{n: own if n in kept else min(own, getattr(usual, n)) for n, own in vars(self).items()})

    @property
    def values(self) -> FloatArray:
        """All sizes (size,), in order."""
        return np.array([getattr(self, item.name) for item in fields(self)])


LOG_MEDIANS = np.log(ErrorSizes().values)
LOG_SPREADS = np.array([item.metadata["spread"] for item in fields(ErrorSizes)])
SIZE_NAMES = tuple(item.name for item in fields(ErrorSizes))
NOMINAL_KINDS = ("stiffness", "mass")
NOMINAL_SCALES = tuple(SIZE_NAMES.index(f"{kind}_scale") for kind in NOMINAL_KINDS)
# Who drew stiffnesses far off drew masses far off, too: three masses alone hardly tell by how much. The correlation of
# the logarithms of both scales.
SCALES_ALIKE = 0.8
LOG_COVARIANCE = np.diag(LOG_SPREADS**2)
LOG_COVARIANCE[NOMINAL_SCALES, NOMINAL_SCALES[::-1]] = SCALES_ALIKE * np.prod(LOG_SPREADS[list(NOMINAL_SCALES)])
LOG_PRECISION = np.linalg.inv(LOG_COVARIANCE)
LOG_ROOT = np.linalg.cholesky(LOG_COVARIANCE)
MAX_SPREADS = 3.0  # prior standard deviations: as far as a size is looked for
LOG_LOWER, LOG_UPPER = LOG_MEDIANS - MAX_SPREADS * LOG_SPREADS, LOG_MEDIANS + MAX_SPREADS * LOG_SPREADS
UNKNOWN_CHANGE = {"frequency": 0.03, "ratio": 3e-3, "shape": 0.15, "phase": 0.02}  # of a structure that has changed
SCALE_OF = {
    "stiffness": "stiffness_scale",
    "mass": "mass_scale",
    "damping": "damping_scale",
    "element": "element_scale",
}
"""Which size is the scale of nominal values of a kind."""


def sizes_at(logs: FloatArray) -> ErrorSizes:
    """Return the sizes of these logarithms (size,)."""
    return replace(ErrorSizes(), **dict(zip(SIZE_NAMES, np.exp(logs).tolist(), strict=True)))
