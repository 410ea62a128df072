"""The error of the simulation's own time steps."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray
from fe_models.causes.base import Cause, parameter
from fe_models.causes.candidate import StepCandidate
from fe_models.causes.known import Known
from fe_models.causes.searched import Searched


def root(omega: FloatArray, ratio: FloatArray) -> ComplexArray:
    """Return lambda = omega (-xi + i sqrt(1 - xi^2)) (1/s), of damping ratios below 1."""
    return np.asarray(omega * (-ratio + 1j * np.sqrt(1 - np.square(ratio))))


@dataclass(frozen=True)
class TimeIntegration(Searched, Cause):
    """A simulation in steps of ``step`` by Newmark's method with constant average acceleration (trapezoidal rule).

    One step maps the state z' = A z to (I - h A / 2)^-1 (I + h A / 2) z, which is the exact motion of another system.
    A mode with lambda = omega (-xi + i sqrt(1 - xi^2)) appears with

        lambda_h = log((1 + h lambda / 2) / (1 - h lambda / 2)) / h,

    without damping omega_h = 2 / h atan(h omega / 2): the period is longer by (h omega)^2 / 12, and no motion decays
    or grows that should not. The shapes stay, and so do the ratios between displacement, velocity and acceleration of a
    mode: 1, lambda, lambda^2, not lambda_h, although it runs by exp(lambda_h t).
    """

    kind: ClassVar[str] = "time_integration"
    template: ClassVar[str] = "the simulation's own step of {step} makes the error: choose a smaller one"
    step: float = parameter("s")

    def frequency_and_ratio(self, omega: FloatArray, ratio: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return omega_h (rad/s) and xi_h of modes with ``omega`` (rad/s) and damping ratios below 1, any shape."""
        shown = self.shown_root(root(omega, ratio))
        return np.abs(shown), -shown.real / np.abs(shown)

    def shown_root(self, exact: ComplexArray) -> ComplexArray:
        """Return lambda_h (1/s) of modes whose exact motion is exp(lambda t), any shape."""
        half = self.step / 2 * exact
        return np.asarray((np.log1p(half) - np.log1p(-half)) / self.step)

    def shown_as(self, omega: FloatArray) -> FloatArray:
        """Return the frequency without damping (rad/s) that shows ``omega`` (rad/s), any shape."""
        return np.asarray(2 / self.step * np.tan(self.step / 2 * omega))

    def faults(self) -> list[str]:
        """Return a fault of a step that is none."""
        return [] if 0 < self.step < np.inf else [f"step = {self.step} s; must be positive"]

    @classmethod
    def candidates(cls, known: Known) -> list[StepCandidate]:
        """Return the steps that the user says the simulation takes."""
        integration = known.nominal.integration
        if integration is None:
            return []
        return [
            StepCandidate(
                kind=cls.kind, location={}, names=(), build=lambda: integration, neutral=(), width=(), lower=()
            )
        ]
