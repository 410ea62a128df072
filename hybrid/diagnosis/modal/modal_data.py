"""What claims are judged by: the nominal model, and the modes of all recordings."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from fe_models.recordings import Sensor, derivative_orders
from fe_models.uncertain_parts import part_correlations
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis


@dataclass(frozen=True)
class ModalData:
    """The ``nominal`` model with the ``offset`` (nuisance,) of its values from what the user drew; the measured
    ``sensors``, their ``rate`` (Hz), and the modes of all ``recordings``.
    """

    nominal: NominalModel
    offset: FloatArray
    sensors: tuple[Sensor, ...]
    rate: float
    recordings: tuple[MeasuredModes, ...]

    @property
    def outputs(self) -> SensorOutputs:
        """The sensors as state spaces take them."""
        return SensorOutputs.measured(self.sensors, self.rate)

    @property
    def modes(self) -> int:
        """Number of all measured modes."""
        return sum(len(own.log_omega) for own in self.recordings)

    @property
    def orders(self) -> IntArray:
        """How often each sensor's signal is the derivative of a displacement, (sensor,)."""
        return derivative_orders(self.sensors)

    @property
    def kinds(self) -> tuple[str, ...]:
        """Whose scale each nominal value (nuisance,) has: "stiffness", "mass", "damping", "element", or "" of none."""
        nominal = self.nominal
        return (
            *(part.quantity for part in nominal.parts),
            *["damping"] * len(nominal.ratios),
            *["element"] * (nominal.values - nominal.factors),
            *[""] * (len(nominal.spread) - nominal.values),
        )

    @cached_property
    def correlation_root(self) -> FloatArray:
        """A lower triangular root (nuisance, nuisance) of the correlations that nominal values have beforehand."""
        parts, structure = self.nominal.parts, self.nominal.structure
        found = np.eye(len(self.nominal.spread))
        found[: len(parts), : len(parts)] = part_correlations(structure, parts)
        return np.asarray(np.linalg.cholesky(found))

    @cached_property
    def null(self) -> Claim:
        """The claim that nothing is wrong."""
        return Claim(Hypothesis(self.nominal))
