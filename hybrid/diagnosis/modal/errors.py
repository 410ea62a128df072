"""How far off a model's modes are where all its values are right, and how far nominal values are off: both estimated.

Every model leaves something out. What it leaves shifts each mode's frequency, damping and shape by amounts that are the
same in all recordings; from one recording to the next they differ by less. The sizes of both, and the scale by which
nominal values are off beyond what was stated, are parameters of the covariance of all that is measured; they are found
by maximum marginal likelihood (type II), beside broad priors.
"""

from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from fe_models.arrays import BoolArray, FloatArray, IntArray

QUANTITIES = ("frequency", "ratio", "shape", "phase")


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
        return -0.5 * float(np.sum(((np.log(self.values) - MEDIANS) / SPREADS) ** 2))

    @property
    def are_usual(self) -> bool:
        """Whether a model whose values are all right may have such errors: none is larger than is usual, but for those
        of damping ratios, which no model has right.
        """
        usual = ErrorSizes()
        names = [name + end for name in QUANTITIES if name != "ratio" for end in ("", "_varies")]
        return all(getattr(self, name) <= getattr(usual, name) for name in names)

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


MEDIANS = np.log(ErrorSizes().values)
SPREADS = np.array([item.metadata["spread"] for item in fields(ErrorSizes)])
NAMES = tuple(item.name for item in fields(ErrorSizes))
FARTHEST = 3.0  # prior standard deviations: as far as a size is looked for
UNKNOWN_CHANGE = {"frequency": 0.03, "ratio": 3e-3, "shape": 0.15, "phase": 0.02}  # of a structure that has changed
SCALES = {"stiffness": "stiffness_scale", "mass": "mass_scale", "damping": "damping_scale", "element": "element_scale"}


@dataclass(frozen=True)
class Rows:
    """What is measured, a value a row: its ``quantity`` (row,), one of `QUANTITIES` by number; the ``mode`` (row,) of
    the structure that it is of; the number of the ``shared`` (row,) error that it has, of its mode, quantity and
    sensor; its ``recording`` (row,).

    ``noise`` (row, row): covariance of the identification. ``slopes`` (row, nuisance) by nominal values, ``spread``
    (nuisance,) their stated standard deviations and ``kind`` (nuisance,) whose scale each has, "" of none. ``changed``
    (row,): in which recordings the structure has changed in an unknown way. ``inflation`` (row,): how many times larger
    than it says the error of the identification is, with what differs from one recording to the next (see `outlying`).
    """

    quantity: IntArray
    mode: IntArray
    shared: IntArray
    recording: IntArray
    noise: FloatArray
    slopes: FloatArray
    spread: FloatArray
    kind: tuple[str, ...]
    changed: BoolArray
    inflation: FloatArray

    @property
    def groups(self) -> FloatArray:
        """Which rows (row, error) have each shared error."""
        found = np.zeros((len(self.shared), int(self.shared.max(initial=-1)) + 1))
        found[np.arange(len(self.shared)), self.shared] = 1.0
        return found

    def scales(self, sizes: ErrorSizes) -> FloatArray:
        """Return the standard deviation (nuisance,) of each nominal value."""
        factor = [getattr(sizes, SCALES[kind]) if kind else 1.0 for kind in self.kind]
        return np.asarray(self.spread * factor)

    def covariance(self, sizes: ErrorSizes) -> FloatArray:
        """Return the covariance (row, row) of all rows, nominal values marginalised."""
        common, varies = (self.by_row(sizes, end) for end in ("", "_varies"))
        groups = self.groups
        weighted = groups * common[:, None]
        total = self.own_noise + weighted @ weighted.T
        total[np.diag_indices_from(total)] += varies**2
        if self.changed.any():
            unknown = groups * (self.unknown_change * sizes.change)[:, None]
            total += unknown @ unknown.T
        moved = self.slopes * self.scales(sizes)
        return np.asarray(total + moved @ moved.T)

    def varies(self, sizes: ErrorSizes) -> FloatArray:
        """Return the standard deviation (row,) of what differs from one recording to the next."""
        return self.by_row(sizes, "_varies")

    def by_row(self, sizes: ErrorSizes, end: str) -> FloatArray:
        """Return the size (row,) of each row's error of its mode, or, ``end`` "_varies", of its recording alone."""
        found = np.array([getattr(sizes, name + end) for name in QUANTITIES])[self.quantity]
        return found * self.inflation if end else found

    @property
    def own_noise(self) -> FloatArray:
        """The covariance (row, row) of the identification, as much larger as it is."""
        return self.noise * np.outer(self.inflation, self.inflation)

    @property
    def unknown_change(self) -> FloatArray:
        """What an unknown change of unit size moves each row by, (row,): nothing where there is none."""
        return np.array([UNKNOWN_CHANGE[name] for name in QUANTITIES])[self.quantity] * self.changed

    @property
    def constant(self) -> float:
        """What a log density of so many rows has whatever they are."""
        return -0.5 * len(self.quantity) * float(np.log(2 * np.pi))


def sizes_of(logs: FloatArray) -> ErrorSizes:
    """Return the sizes of these logarithms (size,)."""
    return replace(ErrorSizes(), **dict(zip(NAMES, np.exp(logs).tolist(), strict=True)))
