"""Free motion in modal coordinates, exact for all that is linear, with whatever other forces act.

    q'' + 2 xi omega q' + omega^2 q = f(q, q', t) for each mode

with f linear in time within each step (exponential integrator with first-order hold): only the course of f between two
steps is approximated, with an error of order 2, and a structure's stiffest modes set no limit to the step.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from fe_models.arrays import FloatArray
from fe_models.causes import ForceLaw, LawWithMemory, MemorylessLaw
from fe_models.linear import LinearModel, ModalModel

Force = Callable[[FloatArray, FloatArray], FloatArray]
"""Modal forces (mode, motion) at modal coordinates and rates (mode, motion)."""

MAX_ITERATIONS = 50  # of Newton's method on the forces of the laws in one step; two are usual
FORCE_TOLERANCE = 1e-7  # relative to the largest force so far: where it stops
SLOW_RATIO = 0.1  # of the last miss: where less was gained, the slope is taken anew


@dataclass(frozen=True)
class Grid:
    """``outputs`` intervals of ``interval`` s from the time ``start`` (s) on, each of ``per_output`` steps."""

    start: float
    interval: float
    outputs: int
    per_output: int

    @property
    def step(self) -> float:
        """The integrator's step (s)."""
        return self.interval / self.per_output


@dataclass(frozen=True)
class _Propagator:
    """One step of all modes: (q, p) -> A (q, p) + from_old f_old + from_new f_new; (2, 2, mode) and (2, mode)."""

    state: FloatArray
    from_old: FloatArray
    from_new: FloatArray


def integrate_motion(
    modal: ModalModel,
    start: tuple[FloatArray, FloatArray],
    grid: Grid,
    rows: list[int],
    laws: tuple[ForceLaw, ...] = (),
    others: Force | None = None,
    known: FloatArray | None = None,
) -> FloatArray:
    """Return displacement, velocity and acceleration of some ``rows``, (3, output, row, motion), at every output.

    ``modal``: all modes of the structure; ``start``: its modal coordinates and their rates, each (mode, motion).
    Forces of the ``laws`` are found by iteration in each step, those of ``others`` are taken at the prediction.
    ``known``: modal forces at each step (step, mode, motion), from the first to beyond the last.
    """
    propagator = _propagator(modal.omega, modal.damping_ratio, grid.step)
    contact = _Contact(modal, laws, propagator, start[0].shape[1], grid.step)
    seen = modal.shapes[rows]  # (row, mode)
    q, p = start
    force = contact.force(q, p, grid.start)
    other = others(q, p) if others else np.zeros_like(q)
    growth = np.zeros_like(q)  # of the other forces in the last step: they are taken to go on like that
    result = np.zeros((3, grid.outputs + 1, len(rows), q.shape[1]))
    stiffness, damping = (modal.omega**2)[:, None], (2 * modal.damping_ratio * modal.omega)[:, None]
    for taken in range(grid.outputs * grid.per_output + 1):
        output, rest = divmod(taken, grid.per_output)
        given, later = (0.0, 0.0) if known is None else known[taken : taken + 2]
        total = force + other + given
        if rest == 0:
            result[:, output] = seen @ q, seen @ p, seen @ (total - stiffness * q - damping * p)
        q, p = (
            propagator.state[i, 0, :, None] * q
            + propagator.state[i, 1, :, None] * p
            + propagator.from_old[i, :, None] * total
            + propagator.from_new[i, :, None] * (other + growth + later)
            for i in (0, 1)
        )
        if laws:
            force = contact.solve(q, p, grid.start + (taken + 1) * grid.step)
            q, p = (part + propagator.from_new[i, :, None] * force for i, part in enumerate((q, p)))
        if others:
            now = others(q, p)
            miss = now - other - growth
            other, growth = now, now - other
            q, p = (part + propagator.from_new[i, :, None] * miss for i, part in enumerate((q, p)))
    return result


def damping_coupling(linear: LinearModel, modal: ModalModel) -> FloatArray:
    """Return what damping couples the modes by, (mode, mode): all but each mode's own."""
    free = modal.shapes[modal.dofs.free]
    damping = free.T @ (linear.damping @ free)
    return np.asarray(damping - np.diag(np.diag(damping)))


def _propagator(omega: FloatArray, ratio: FloatArray, step: float) -> _Propagator:
    """Return the step of each mode from the exponential of its equation with a force that grows evenly."""
    system = np.zeros((len(omega), 4, 4))  # of omega q, p, the force at the step's beginning, and what it grows by
    system[:, 0, 1] = omega
    system[:, 1, 0] = -omega
    system[:, 1, 1] = -2 * ratio * omega
    system[:, 1, 2] = 1.0
    system[:, 2, 3] = 1 / step
    moved = np.moveaxis(expm(step * system), 0, -1)  # (4, 4, mode)
    scale = np.stack([1 / omega, np.ones_like(omega)])  # from (omega q, p) to (q, p)
    state = moved[:2, :2] * scale[:, None] / scale[None]
    return _Propagator(state, (moved[:2, 2] - moved[:2, 3]) * scale, moved[:2, 3] * scale)


class _Contact:
    """The force laws in modal coordinates: elongations, their forces, and these solved for in a step."""

    def __init__(
        self,
        modal: ModalModel,
        laws: tuple[ForceLaw, ...],
        propagator: _Propagator,
        motions: int,
        step: float,
    ) -> None:
        """Start at rest; ``motions`` are marched side by side."""
        pulls = np.zeros((len(laws), len(modal.dofs)))
        for number, law in enumerate(laws):
            pulls[number] = modal.dofs.pull(law.pulls)
        self._laws, self._step = laws, step
        self._pulls = pulls @ modal.shapes  # (law, mode)
        # What a force of 1 N at the end of the step adds to u and v there: (law, law) each.
        self._gains = [(self._pulls * part) @ self._pulls.T for part in propagator.from_new]
        self._memory = np.zeros((len(laws), motions))
        self._rate = np.zeros((len(laws), motions))
        self._now = np.zeros((len(laws), motions))
        self._slope = np.zeros((len(laws), motions))
        self._largest = 0.0

    def force(self, q: FloatArray, p: FloatArray, time: float) -> FloatArray:
        """Return the modal forces (mode, motion) at the start."""
        u, v = self._pulls @ q, self._pulls @ p
        self._rate = v
        for i, law in enumerate(self._laws):
            if isinstance(law, LawWithMemory):
                self._memory[i] = law.pulled_to(u[i])
        self._now = self._forces(u, v, time, self._memory)
        return np.asarray(-self._pulls.T @ self._now)

    def solve(self, q: FloatArray, p: FloatArray, time: float) -> FloatArray:
        """Return the modal forces (mode, motion) at the end of a step that without them ends at ``q`` and ``p``."""
        u, v = self._pulls @ q, self._pulls @ p
        now, last = self._now, np.inf
        for _ in range(MAX_ITERATIONS):
            here = (u - self._gains[0] @ now, v - self._gains[1] @ now)
            forces = self._forces(*here, time, None)
            miss = forces - now
            size = float(np.abs(miss).max())
            self._largest = max(self._largest, float(np.abs(forces).max()))
            if size <= FORCE_TOLERANCE * self._largest:
                break
            if size > SLOW_RATIO * last:
                self._slope = self._slope_at(here, forces, time)
            now, last = now + miss / (1 - self._slope), size
        self._now = now
        rate = v - self._gains[1] @ now
        self._memory = self._remembered(rate)
        self._rate = rate
        return np.asarray(-self._pulls.T @ now)

    def _slope_at(self, here: tuple[FloatArray, FloatArray], forces: FloatArray, time: float) -> FloatArray:
        """Return how much each law's force (law, motion) grows at the end of a step for each newton of its own."""
        nudge = 1e-6 * self._largest + 1e-12  # N
        u, v = (part - gain.diagonal()[:, None] * nudge for part, gain in zip(here, self._gains, strict=True))
        # Where the force eases (a softening spring), plain iteration is surer than a division by little.
        return np.minimum((self._forces(u, v, time, None) - forces) / nudge, 0.0)

    def _forces(self, u: FloatArray, v: FloatArray, time: float, memory: FloatArray | None) -> FloatArray:
        """Return the laws' forces (law, motion); ``memory`` None: as it will be after this step."""
        memory = self._remembered(v) if memory is None else memory
        forces = np.empty_like(u)
        for i, law in enumerate(self._laws):
            if isinstance(law, LawWithMemory):
                forces[i] = law.force_of(memory[i])
            elif isinstance(law, MemorylessLaw):
                forces[i] = law.force(u[i], v[i], time)
        return forces

    def _remembered(self, v: FloatArray) -> FloatArray:
        """Return what laws remember (law, motion) after a step that ends at rates ``v``: by Heun's method."""
        memory = self._memory.copy()
        for i, law in enumerate(self._laws):
            if isinstance(law, LawWithMemory):
                first = law.rate(self._rate[i], memory[i])
                last = law.rate(v[i], memory[i] + self._step * first)
                memory[i] += self._step / 2 * (first + last)
        return memory
