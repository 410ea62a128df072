"""Claims about a structure, and what they are judged by: the nominal model and the modes of all recordings."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from fe_models.recordings import QUANTITIES, Sensor
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis


@dataclass(frozen=True)
class Claim:
    """What is wrong: the candidates of a ``hypothesis``, each in the recordings (numbers) of ``acts``; ``changed``:
    those whose structure has changed in an unknown way.
    """

    hypothesis: Hypothesis
    acts: tuple[tuple[int, ...], ...] = ()
    changed: tuple[int, ...] = ()

    def off(self, recording: int) -> tuple[int, ...]:
        """Return the numbers of the candidates that do not act in a recording."""
        return tuple(number for number, acts in enumerate(self.acts) if recording not in acts)

    def less(self, number: int) -> "Claim":
        """Return the claim without one of its candidates."""
        acts = tuple(own for position, own in enumerate(self.acts) if position != number)
        return Claim(self.hypothesis.less((number,)), acts, self.changed)

    def within(self, recordings: Sequence[int]) -> tuple["Claim", tuple[int, ...]]:
        """Return the claim about some ``recordings`` alone, numbered anew, and the numbers of the candidates that act
        in none of them.
        """
        idle = tuple(number for number, acts in enumerate(self.acts) if not set(acts) & set(recordings))
        own = [acts for number, acts in enumerate(self.acts) if number not in idle]
        acts, (changed,) = (
            tuple(tuple(new for new, old in enumerate(recordings) if old in some) for some in several)
            for several in (own, [self.changed])
        )
        return Claim(self.hypothesis.less(idle), acts, changed), idle

    @property
    def key(self) -> tuple[object, ...]:
        """What two equal claims have in common."""
        named = zip(self.hypothesis.candidates, self.acts, strict=True)
        return tuple(sorted((candidate.key, acts) for candidate, acts in named)), self.changed


@dataclass(frozen=True)
class Measured:
    """What evidence is made of: the ``nominal`` model, ``offset`` (nuisance,) of its values from what the user drew,
    the measured ``sensors``, their ``rate`` (Hz), and the modes of all ``recordings``.
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
        return np.array([QUANTITIES.index(sensor.quantity) for sensor in self.sensors])

    @property
    def kind(self) -> tuple[str, ...]:
        """Whose scale each nuisance (nuisance,) has: "stiffness", "mass", "damping", "element", or "" of none."""
        nominal = self.nominal
        parts = [part.quantity for part in nominal.parts] + ["damping"] * len(nominal.ratios)
        return (
            *parts,
            *["element"] * (nominal.values - nominal.factors),
            *[""] * (len(nominal.spread) - nominal.values),
        )

    @cached_property
    def null(self) -> Claim:
        """The claim that nothing is wrong."""
        return Claim(Hypothesis(self.nominal))
