"""What is measured of all modes, a value a row, with how far each row may be off and what rows share."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import BoolArray, FloatArray, IntArray
from hybrid.diagnosis.modal.error_sizes import SCALE_OF, UNKNOWN_CHANGE, ErrorSizes
from hybrid.diagnosis.modal.mode_values import MODE_QUANTITIES


@dataclass(frozen=True)
class Rows:
    """What is measured, a value a row: its ``quantity`` (row,), a number among `MODE_QUANTITIES`; the ``mode`` (row,)
    of the structure that it is of; the number of the ``shared`` (row,) error that it has, of its mode, quantity and
    sensor; its ``recording`` (row,).

    ``noise`` (row, row): covariance of the identification. ``slopes`` (row, nuisance) by nominal values, ``spread``
    (nuisance,) their stated standard deviations, ``correlation_root`` (nuisance, nuisance) a lower triangular root of
    their correlations, and ``kinds`` (nuisance,) whose scale each has, "" of none: values of two kinds have no
    correlation. ``changed`` (row,): in which recordings the structure has changed in an unknown way. ``inflation``
    (row,): how many times larger than it says the error of the identification is, with what differs from one recording
    to the next (see `inflation`).
    """

    quantity: IntArray
    mode: IntArray
    shared: IntArray
    recording: IntArray
    noise: FloatArray
    slopes: FloatArray
    spread: FloatArray
    correlation_root: FloatArray
    kinds: tuple[str, ...]
    changed: BoolArray
    inflation: FloatArray

    @property
    def sharing(self) -> FloatArray:
        """One where a row has a shared error, else nothing, (row, error)."""
        found = np.zeros((len(self.shared), int(self.shared.max(initial=-1)) + 1))
        found[np.arange(len(self.shared)), self.shared] = 1.0
        return found

    def scales(self, sizes: ErrorSizes) -> FloatArray:
        """Return the standard deviation (nuisance,) of each nominal value."""
        factor = [getattr(sizes, SCALE_OF[kind]) if kind else 1.0 for kind in self.kinds]
        return np.asarray(self.spread * factor)

    def prior_root(self, sizes: ErrorSizes) -> FloatArray:
        """Return a root (nuisance, nuisance) of the prior covariance of all nominal values."""
        return np.asarray(self.scales(sizes)[:, None] * self.correlation_root)

    def covariance(self, sizes: ErrorSizes) -> FloatArray:
        """Return the covariance (row, row) of all rows, nominal values marginalised."""
        return self.with_values_unknown(sizes, self.covariance_of_errors(sizes))

    def with_values_unknown(self, sizes: ErrorSizes, known: FloatArray) -> FloatArray:
        """Return a covariance (row, row) of all rows, where nominal values are ``known``, with these marginalised."""
        moved = self.slopes @ self.prior_root(sizes)
        return np.asarray(known + moved @ moved.T)

    def covariance_of_errors(self, sizes: ErrorSizes) -> FloatArray:
        """Return the covariance (row, row) of all rows where nominal values are known."""
        common, varying = self.common(sizes), self.varying(sizes)
        alike = self.shared[:, None] == self.shared
        total = self.own_noise + alike * np.outer(common, common)
        total[np.diag_indices_from(total)] += varying**2
        if self.changed.any():
            unknown = self.unknown_change * sizes.change
            total += alike * np.outer(unknown, unknown)
        return np.asarray(total)

    def common(self, sizes: ErrorSizes) -> FloatArray:
        """Return the standard deviation (row,) of the error that a row's mode has in all recordings."""
        return np.asarray(sizes.common[self.quantity])

    def varying(self, sizes: ErrorSizes) -> FloatArray:
        """Return the standard deviation (row,) of what differs from one recording to the next."""
        return np.asarray(sizes.varying[self.quantity] * self.inflation)

    @property
    def own_noise(self) -> FloatArray:
        """The covariance (row, row) of the identification, as much larger as it is."""
        return self.noise * np.outer(self.inflation, self.inflation)

    @property
    def unknown_change(self) -> FloatArray:
        """What an unknown change of unit size moves each row by, (row,): nothing where there is none."""
        return np.array([UNKNOWN_CHANGE[name] for name in MODE_QUANTITIES])[self.quantity] * self.changed

    @property
    def log_constant(self) -> float:
        """What a log density of so many rows has whatever they are."""
        return -0.5 * len(self.quantity) * float(np.log(2 * np.pi))
