"""One kind of cause at one place, as a search takes it: a family for each way in which causes enter the equations.

What a family adds says how: what is set in M, C and K, along which elongation a force acts, which number of a sensor it
is. A cause says in its own file at which places it makes which candidates.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.causes.base import Cause
from fe_models.causes.force_law import LawWithMemory

# of a prior width: the step at which a response counts as of first order, however long a recording is
FIRST_ORDER_STEP = 1e-5
UNBOUNDED = (-np.inf,)

Changes = tuple[csr_array, csr_array, csr_array]
"""dM, dC, dK, sparse (dof, dof)."""


@dataclass(frozen=True, kw_only=True)
class Candidate(ABC):
    """One kind of cause at one place: its parameters, where a search starts and ends.

    ``build`` makes the cause from its parameters (of arrays, one of arrays). ``names``: their words; ``neutral``:
    values at which it does nothing; ``width``: prior standard deviations about them; ``lower`` and ``upper`` (empty:
    none): bounds; ``starts``: values at which a search may begin; with ``scalable`` the first of them is small, and the
    score test finds its size; ``negligible``: values at which it hardly acts, of what no small size makes weak;
    ``far``: values of its only parameter that a scan tries besides those near its prior.
    ``brings``: number of modes that are followed only with it: those that come down into the recordings' band.
    ``twins``: other places where it would do the same. ``weight``: how probable its place is beforehand, to the usual
    one of its kind.
    """

    kind: str
    location: dict[str, Any]
    names: tuple[str, ...]
    build: Callable[..., Cause] = field(compare=False, repr=False)
    neutral: tuple[float, ...]
    width: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...] = ()
    starts: tuple[tuple[float, ...], ...] = ()
    scalable: bool = True
    negligible: tuple[float, ...] = ()
    far: tuple[float, ...] = ()
    brings: int = 0
    twins: tuple[dict[str, Any], ...] = ()
    weight: float = 1.0

    @property
    @abstractmethod
    def is_structural(self) -> bool:
        """Whether it changes the structure's own matrices or damping ratios."""

    @property
    def first_starts(self) -> tuple[tuple[float, ...], ...]:
        """The ``starts``; where none are given, a small step away from doing nothing."""
        if self.starts or not self.names:
            return self.starts or ((),)
        return (tuple(a + FIRST_ORDER_STEP * b for a, b in zip(self.neutral, self.width, strict=True)),)

    @property
    def without(self) -> tuple[float, ...]:
        """Values at which it does nothing that can be computed with."""
        return self.neutral

    @property
    def key(self) -> str:
        """Kind and place as one word, the same for the same candidate."""
        return f"{self.kind} {self.location}"

    @property
    def reported_location(self) -> dict[str, Any]:
        """Its location in the words of a report: what is a parameter there, as the side of a stop, is left out."""
        parameters = self.build(*self.width).units
        return {word: value for word, value in self.location.items() if word not in parameters}

    @property
    def listed_with(self) -> str:
        """What it is listed together with; most by themselves."""
        return self.key


@dataclass(frozen=True, kw_only=True)
class MatrixCandidate(Candidate, ABC):
    """What changes M, C or K: by ``changes`` for each unit of its `amount`.

    ``pulls`` (dof, force): along which it acts, where that is known beforehand; None: as its changes have it.
    """

    changes: Changes = field(compare=False, repr=False)
    pulls: FloatArray | None = field(default=None, compare=False, repr=False)

    @property
    def is_structural(self) -> bool:
        """True."""
        return True

    def amount(self, values: FloatArray) -> FloatArray:
        """Return how many of its ``changes`` a parameter (variant,) stands for."""
        return values - self.neutral[0]


@dataclass(frozen=True, kw_only=True)
class ChangeCandidate(MatrixCandidate):
    """A change of M or K of a structure whose supports hold: it turns the modes.

    ``part``: the uncertain stiffness, by its number, whose factor its changes go with; None where it stands alone.
    """

    part: int | None = None


@dataclass(frozen=True, kw_only=True)
class DashpotCandidate(MatrixCandidate):
    """Damping on top of the structure's own, whose ratios are uncertain."""


@dataclass(frozen=True, kw_only=True)
class SupportCandidate(MatrixCandidate):
    """A support that gives way: ``row`` is the degree of freedom that it holds in the nominal structure.

    The parameter is the compliance there.
    """

    row: int

    @property
    def without(self) -> tuple[float, ...]:
        """A support as good as rigid: a rigid one cannot be computed with."""
        return self.lower

    def amount(self, values: FloatArray) -> FloatArray:
        """Return the stiffness of a compliance (variant,)."""
        return 1 / values


@dataclass(frozen=True, kw_only=True)
class ModeCandidate(Candidate):
    """Another damping ratio of one ``mode``, from 0."""

    mode: int

    @property
    def is_structural(self) -> bool:
        """True."""
        return True


@dataclass(frozen=True, kw_only=True)
class ForceCandidate(Candidate, ABC):
    """A force along the elongation ``pull`` (dof,)."""

    pull: FloatArray = field(compare=False, repr=False)

    @property
    def is_structural(self) -> bool:
        """False."""
        return False


@dataclass(frozen=True, kw_only=True)
class LawCandidate(ForceCandidate):
    """A force that is not linear in the motion: a `ForceLaw`.

    ``part``: the uncertain stiffness, by its number, of the element whose law it is; None of others.
    """

    part: int | None = None

    @cached_property
    def has_memory(self) -> bool:
        """Whether its force depends on the way of the motion (`LawWithMemory`)."""
        return isinstance(self.build(*self.width), LawWithMemory)

    @property
    def listed_with(self) -> str:
        """The other laws of its place."""
        return f"force law {self.reported_location}"


@dataclass(frozen=True, kw_only=True)
class HarmonicCandidate(ForceCandidate):
    """A harmonic force, whose amplitude and phase are each recording's own: two entries of its initial state."""


@dataclass(frozen=True, kw_only=True)
class SensorCandidate(Candidate):
    """A fault of one ``sensor``, by its position among the measured ones; its parameter is the sensor's ``quantity``:
    a gain, a delay (s) or a drift (its unit a second).
    """

    sensor: int
    quantity: Literal["gain", "delay", "drift"]

    @property
    def is_structural(self) -> bool:
        """False."""
        return False

    @property
    def listed_with(self) -> str:
        """The other faults of its sensor."""
        return f"fault {self.location}"


@dataclass(frozen=True, kw_only=True)
class LoadCandidate(Candidate):
    """A fault in how known loads, or the base's motion, were recorded: ``loads``, by their positions among what is
    known, all of which were recorded alike; its parameter is their ``quantity``: a gain or a delay (s).
    """

    loads: tuple[int, ...]
    quantity: Literal["gain", "delay"]

    @property
    def is_structural(self) -> bool:
        """False."""
        return False

    @property
    def listed_with(self) -> str:
        """The other faults of the load."""
        return f"fault {self.location}"


@dataclass(frozen=True, kw_only=True)
class StepCandidate(Candidate):
    """The simulation's own time steps, which act or do not."""

    @property
    def is_structural(self) -> bool:
        """False."""
        return False
