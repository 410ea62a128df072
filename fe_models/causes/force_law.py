"""Forces that depend on motion: at once, or on what the motion was before."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from fe_models.structure import Direction


class ForceLaw(ABC):
    """A force along one elongation u = sum of c u(node, direction), with v its rate.

    M u'' + C u' + K u + b f = 0, b holding the coefficients c of the `pulls`: f is that of a `MemorylessLaw` or of a
    `LawWithMemory`. u is measured from the state at rest (in a linear model zero) and t (s) from the start of the
    motion.
    """

    kind: ClassVar[str]
    timed: ClassVar[bool] = False  # whether the force depends on t

    @property
    @abstractmethod
    def pulls(self) -> tuple[tuple[int, Direction, float], ...]:
        """Where it acts: (node, direction, coefficient) of each degree of freedom in the elongation."""

    def with_stiffness(self, factor: Any) -> "ForceLaw":
        """Return the law where the element that it belongs to is ``factor`` times as stiff; itself without one."""
        return self

    @property
    def largest_slopes(self) -> tuple[float, float]:
        """The largest |d force/du| (N/m) and |d force/dv| (N s/m), 0 where they know no bound: steps depend on them."""
        return 0.0, 0.0


class MemorylessLaw(ForceLaw):
    """A force f(u, v, t) that depends on where the motion is."""

    @abstractmethod
    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return the restoring force (N) at elongation ``u`` (m), rate ``v`` (m/s) and time ``t`` (s), any shape.

        Plain arithmetic: takes floats, arrays, tensors and Exudyn's symbolic numbers alike.
        """


class LawWithMemory(ForceLaw):
    """A force f(z) of an internal elongation z (m) that follows u in its own way: z' = rate(v, z), 0 at rest.

    It depends on the way that led to where the motion is. Motion begins where a slow pull from rest would have led.
    """

    @property
    @abstractmethod
    def largest(self) -> float:
        """The largest |z| (m) that it can have: an integrator that exceeds it takes steps that are too long."""

    @abstractmethod
    def rate(self, v: Any, z: Any) -> Any:
        """Return z' (m/s) at the rate ``v`` (m/s) and ``z`` (m), floats or arrays."""

    @abstractmethod
    def force_of(self, z: Any) -> Any:
        """Return the restoring force (N) at ``z`` (m), floats or arrays."""

    @abstractmethod
    def pulled_to(self, u: Any) -> Any:
        """Return z (m) after a slow pull from rest to the elongation ``u`` (m), floats or arrays."""


class SlowPull(MemorylessLaw):
    """A law with memory while it is pulled slowly, one way, from rest."""

    def __init__(self, law: LawWithMemory) -> None:
        self._law = law

    @property
    def pulls(self) -> tuple[tuple[int, Direction, float], ...]:
        """Those of the law."""
        return self._law.pulls

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return the force (N) after the pull to ``u`` (m), floats or arrays."""
        return self._law.force_of(self._law.pulled_to(u))
