"""One kind of cause at one place: what it changes, its parameters, where a search starts and ends."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.causes import Cause, PointDamper

SMALL = 1e-5  # of a prior width: the step at which a response counts as of first order, however long a recording is


@dataclass(frozen=True)
class Candidate:
    """One kind of cause at one place.

    ``build`` makes the cause from its parameters (of arrays, one of arrays). ``names``: their words; ``neutral``:
    values at which it does nothing; ``width``: prior standard deviations about them; ``lower`` and ``upper`` (empty:
    none): bounds; ``starts``: values at which a search may begin; with ``scalable`` the first of them is small, and the
    score test finds its size; ``hardly``: values at which it hardly acts, of what no small size makes weak.
    The cause is felt by what of the following is set: ``changes`` dM, dC, dK, sparse (dof, dof), for each unit of its
    `amount`, times the factor of the plant's uncertain ``part`` if it has one, ``mode`` (from 0), ``pull`` (dof,) of a
    force law or of an ``oscillator``, ``sensor`` (position among the measured ones), or nothing (the time steps).
    ``released``: the row that a support holds in the nominal structure; the parameter is then the compliance there.
    ``brings``: number of modes that are followed only with it: that of a support which gives way, those that come down
    into the recordings' band. ``twins``: other places where it would do the same. ``weight``: how probable its place is
    beforehand, to the usual one of its kind.
    """

    kind: str
    location: dict[str, Any]
    names: tuple[str, ...]
    build: Callable[..., Cause] = field(compare=False, repr=False)
    neutral: tuple[float, ...]
    width: tuple[float, ...]
    lower: tuple[float, ...]
    starts: tuple[tuple[float, ...], ...] = ()
    scalable: bool = True
    hardly: tuple[float, ...] = ()
    changes: tuple[csr_array, csr_array, csr_array] | None = field(default=None, compare=False, repr=False)
    part: int | None = None
    mode: int | None = None
    pull: FloatArray | None = field(default=None, compare=False, repr=False)
    oscillator: bool = False
    sensor: int | None = None
    released: int | None = None
    brings: int = 0
    upper: tuple[float, ...] = ()
    twins: tuple[dict[str, Any], ...] = ()
    weight: float = 1.0

    def amount(self, values: FloatArray) -> FloatArray:
        """Return how many of its ``changes`` a parameter (variant,) stands for."""
        return values - self.neutral[0] if self.released is None else 1 / values

    @property
    def first_starts(self) -> tuple[tuple[float, ...], ...]:
        """The ``starts``; where none are given, a small step away from doing nothing."""
        if self.starts or not self.names:
            return self.starts or ((),)
        return (tuple(a + SMALL * b for a, b in zip(self.neutral, self.width, strict=True)),)

    @property
    def without(self) -> tuple[float, ...]:
        """Values at which it does nothing that can be computed with: a support as good as rigid is not quite."""
        return self.neutral if self.released is None else self.lower

    @property
    def is_law(self) -> bool:
        """Whether it is a force that is not linear in the motion."""
        return self.pull is not None and not self.oscillator

    @property
    def is_dashpot(self) -> bool:
        """Whether it is damping on top of the structure's own, whose ratios are uncertain."""
        return self.kind == PointDamper.kind

    @property
    def is_structural(self) -> bool:
        """Whether it changes the structure's own matrices or damping ratios."""
        return self.changes is not None or self.mode is not None

    @property
    def turns_modes(self) -> bool:
        """Whether it changes M or K of a structure whose supports hold."""
        return self.changes is not None and not self.is_dashpot and self.released is None

    @property
    def key(self) -> str:
        """Kind and place as one word, the same for the same candidate."""
        return f"{self.kind} {self.location}"
