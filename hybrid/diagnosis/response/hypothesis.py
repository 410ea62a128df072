"""A hypothesis: nominal model, its uncertain factors and a few candidates; what each parameter vector stands for."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TypeVar

import numpy as np

from fe_models.arrays import BoolArray, FloatArray
from fe_models.causes.candidate import (
    Candidate,
    ChangeCandidate,
    DashpotCandidate,
    HarmonicCandidate,
    LawCandidate,
    MatrixCandidate,
    ModeCandidate,
    SupportCandidate,
)
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response.config import HYPOTHESIS
from hybrid.diagnosis.response.damping import assumed_damping, more_damping
from hybrid.diagnosis.response.dashpots import trailing_of
from hybrid.diagnosis.response.dispersion import dispersed, dispersed_squares
from hybrid.diagnosis.response.eigenmodes import aligned_modes, eigenmodes
from hybrid.diagnosis.response.reduced_model import ReducedModel
from hybrid.diagnosis.response.reduction import Basis, basis_of
from hybrid.diagnosis.response.residual_modes import ResidualModes, residual_modes_of

Family = TypeVar("Family", bound=Candidate)


@dataclass(frozen=True)
class _Drawn:
    """``mass``, ``damping`` and ``stiffness`` (variant, vector, vector) without the causes that turn the modes; one
    variant where all have the same.
    """

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray


@dataclass(frozen=True)
class _Built:
    """``mass``, ``damping``, ``stiffness``, and what ``dashpots`` damp (variant, vector, vector) in the basis of a
    hypothesis; ``drawn``: None where no cause turns the modes.
    """

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    dashpots: FloatArray
    drawn: _Drawn | None


@dataclass(frozen=True)
class Hypothesis:
    """Parameter vectors theta (..., parameter): of the ``nominal`` model (see its ``spread``), then the candidates'."""

    nominal: NominalModel
    candidates: tuple[Candidate, ...] = ()

    def adding(self, candidate: Candidate) -> "Hypothesis":
        """Return the hypothesis with one more candidate."""
        return replace(self, candidates=(*self.candidates, candidate))

    def less(self, off: tuple[int, ...]) -> "Hypothesis":
        """Return the hypothesis without the candidates whose numbers are ``off``."""
        kept = tuple(candidate for number, candidate in enumerate(self.candidates) if number not in off)
        return replace(self, candidates=kept) if off else self

    def parameters_of(self, off: tuple[int, ...]) -> list[int]:
        """Return the entries of theta that the hypothesis has `less` some candidates, too."""
        every = range(len(self.centre))
        own = [k for number, part in enumerate(self.slices) if number not in off for k in every[part]]
        return [*range(self.nuisances), *own]

    def states_of(self, off: tuple[int, ...]) -> list[int]:
        """Return the entries of an initial state that the hypothesis has `less` some candidates, too.

        A support that gives way brings a coordinate, the last one; harmonic forces have two entries each behind it.
        """
        n, m = self.size, self.less(off).size
        harmonics = [number for number, c in enumerate(self.candidates) if isinstance(c, HarmonicCandidate)]
        own = [2 * n + 2 * k + part for k, number in enumerate(harmonics) if number not in off for part in (0, 1)]
        return [*range(m), *range(n, n + m), *own]

    def embedded(self, states: FloatArray, off: tuple[int, ...], initial_force: float = 0.0) -> FloatArray:
        """Return initial states (recording, state) from those that the hypothesis has `less` some candidates: at rest
        in what these bring, their harmonic forces begin with ``initial_force``, N.
        """
        whole = np.zeros((len(states), self.states))
        whole[:, 2 * self.size :] = initial_force
        whole[:, self.states_of(off)] = states
        return whole

    def each(self, family: type[Family]) -> list[tuple[Family, slice]]:
        """Return the candidates of one family and where their parameters stand in theta."""
        every = zip(self.candidates, self.slices, strict=True)
        return [(candidate, part) for candidate, part in every if isinstance(candidate, family)]

    @property
    def nuisances(self) -> int:
        """Number of uncertain factors, the first entries of theta."""
        return len(self.nominal.spread)

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Where each candidate's parameters stand in theta."""
        ends = np.cumsum([self.nuisances, *(len(c.names) for c in self.candidates)])
        return tuple(slice(int(a), int(b)) for a, b in pairwise(ends))

    @property
    def centre(self) -> FloatArray:
        """The prior mean (parameter,)."""
        own = [value for c in self.candidates for value in c.neutral]
        return np.array([0.0] * self.nuisances + own)

    @property
    def width(self) -> FloatArray:
        """The prior standard deviation (parameter,)."""
        return np.array([*self.nominal.spread, *(value for c in self.candidates for value in c.width)])

    @property
    def precision(self) -> FloatArray:
        """What the square of a deviation from the centre costs, (parameter,), beside squares of what is left.

        Of the factors, which the user knows, as many times more as there are values that are worth one independent
        value. The scatter is why these are alike, and how damping turns nobody stated: both count once.
        """
        counts = np.ones(len(self.centre))
        counts[: self.nominal.factors] = self.nominal.alike
        return np.asarray(counts / self.width**2)

    @property
    def lower(self) -> FloatArray:
        """The least values (parameter,)."""
        own = [value for c in self.candidates for value in c.lower]
        return np.array([-HYPOTHESIS.max_log_factor] * self.nuisances + own)

    @property
    def upper(self) -> FloatArray:
        """The largest values (parameter,)."""
        own = [value for c in self.candidates for value in c.upper or (np.inf,) * len(c.names)]
        return np.array([HYPOTHESIS.max_log_factor] * self.nuisances + own)

    @property
    def laws(self) -> tuple[LawCandidate, ...]:
        """The candidates that are force laws."""
        return tuple(candidate for candidate in self.candidates if isinstance(candidate, LawCandidate))

    @property
    def is_linear(self) -> bool:
        """Whether the channels are linear in the initial state."""
        return not self.nominal.laws and not self.laws

    @property
    def is_beside_law(self) -> bool:
        """Whether the last candidate stands beside a force law."""
        return any(isinstance(candidate, LawCandidate) for candidate in self.candidates[:-1])

    @cached_property
    def basis(self) -> Basis:
        """The shapes in which the hypothesis moves, and its matrices there."""
        return basis_of(self.nominal, self.candidates)

    @property
    def size(self) -> int:
        """Number of coordinates whose motion is followed."""
        whole = self.basis.mass.shape[0]
        return whole if self.nominal.kept is None else min(self.nominal.kept + self.brought, whole)

    @property
    def brought(self) -> int:
        """Number of modes that are followed beyond the nominal model's own: see `Candidate`."""
        return sum(c.brings for c in self.candidates)

    @property
    def states(self) -> int:
        """Number of entries of an initial state: displacements, velocities, two for each harmonic force."""
        return 2 * self.size + 2 * sum(isinstance(c, HarmonicCandidate) for c in self.candidates)

    def own_motions(self, theta: FloatArray) -> list[FloatArray]:
        """Return what initial states (state,) have at ``theta`` (parameter,) that those of other hypotheses do not,
        rows (part, state) of parts of like size: displacement and velocity of the modes brought, the forces.

        Of modes, not of coordinates: these keep their meaning, and hold a part of all modes where these have changed.
        """
        every, n = np.eye(self.states), self.size
        found = [every[[first, first + 1]] for first in range(2 * n, self.states, 2)]
        _, rows = self._modes_brought(theta)
        return found + [row[None] @ every[part] for row in rows for part in (slice(n), slice(n, 2 * n))]

    def extra_entries(self, theta: FloatArray, states: tuple[FloatArray, ...]) -> int:
        """Return how many of the entries of initial ``states`` (recording, state), a batch each, others do not have and
        take up noise at ``theta`` (parameter,): of a mode beyond a low-pass they take none, as none is left there.
        """
        silent = int(np.sum(self._modes_brought(theta)[0] > self.nominal.cutoff))
        common = 2 * (self.size - self.brought + silent)
        return sum(len(part) * max(part.shape[1] - common, 0) for part in states)

    def _modes_brought(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the natural frequencies (mode,), rad/s, of the modes brought, the highest at ``theta``, and how much
        of each coordinate is in them, (mode, coordinate).
        """
        if not self.brought:
            return np.zeros(0), np.zeros((0, self.size))
        reduced = self.reduced(theta[None])
        modes = eigenmodes(reduced.mass, reduced.stiffness)
        own = slice(-self.brought, None)
        return modes.omega[0, own], modes.shapes[0, :, own].T @ reduced.mass[0]

    def weighs(self, theta: FloatArray) -> BoolArray:
        """Return whether every motion has mass at a ``theta``, (variant,) of (variant, parameter): not where more is
        taken off a node than moves with it.
        """
        masses = [(c, change[0], part.start) for c, change, part in self._matrix_candidates if change[0].any()]
        if not masses:
            return np.ones(len(theta), dtype=bool)
        M = self._drawn_mass(np.exp(theta[:, : len(self.nominal.parts)]))
        for candidate, change, first in masses:
            M = M + candidate.amount(theta[:, first])[:, None, None] * change
        return np.asarray(np.linalg.eigvalsh(M)[:, 0] > HYPOTHESIS.min_mass_share * np.abs(M).max(axis=(1, 2)))

    @property
    def _matrix_candidates(self) -> list[tuple[MatrixCandidate, FloatArray, slice]]:
        """The candidates that change M, C or K, with a unit of their changes in the basis and their place in theta."""
        every = zip(self.candidates, self.basis.changes, self.slices, strict=True)
        return [(c, change, part) for c, change, part in every if isinstance(c, MatrixCandidate) and change is not None]

    def _replaced(self, theta: FloatArray) -> list[tuple[int, FloatArray]]:
        """Return the modes with a damping ratio of their own, from 0, and these ratios (variant,)."""
        return [(candidate.mode, theta[:, part.start]) for candidate, part in self.each(ModeCandidate)]

    def _drawn_mass(self, factor: FloatArray) -> FloatArray:
        """Return M (variant, shape, shape) with the parts' mass a ``factor`` (variant, part) times as large."""
        basis, of_mass = self.basis, self._of_mass
        return basis.mass + np.tensordot(factor[:, of_mass] - 1, basis.parts[of_mass], axes=1)

    def _carried(self, theta: FloatArray) -> FloatArray:
        """Return the mass that a moving base carries along, (variant, shape, load): shapes^T M r."""
        basis, of_mass = self.basis, self._of_mass
        more = np.exp(theta[:, : len(of_mass)][:, of_mass]) - 1
        carried = basis.carried + np.einsum("pe,eil->pil", more, basis.carried_parts[of_mass])
        every = zip(self.candidates, self.slices, basis.carried_changes, strict=True)
        for candidate, part, change in every:
            if isinstance(candidate, MatrixCandidate) and change is not None and change.any():
                carried = carried + candidate.amount(theta[:, part.start])[:, None, None] * change
        return carried

    @property
    def _of_mass(self) -> BoolArray:
        """Which of the nominal model's parts (part,) are masses; the others are stiffnesses."""
        return np.array([part.quantity == "mass" for part in self.nominal.parts], dtype=bool)

    def natural_modes(self, theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the squared natural frequencies (variant, mode), (rad/s)^2, and the mass-normalised shapes (variant,
        dof, mode) of the modes that are followed at ``theta`` (variant, parameter), as the system has them.
        """
        built, nominal = self._built(theta), self.nominal
        modes = eigenmodes(built.mass, built.stiffness)
        omega2, shapes = modes.omega2[:, : self.size], modes.shapes[..., : self.size]
        if nominal.disperses:
            omega2 = dispersed_squares(omega2, theta[:, nominal.dispersion], nominal.rate)
        return omega2, self.basis.shapes @ shapes

    def reduced(self, theta: FloatArray, first_order: bool = False) -> ReducedModel:
        """Return M, C, K and the shapes of ``theta`` (variant, parameter); ``first_order``: see `eigenmodes`."""
        nominal, basis, built = self.nominal, self.basis, self._built(theta)
        M, C, K, dashpots = built.mass, built.damping, built.stiffness, built.dashpots
        own = np.exp(theta[:, len(nominal.parts) : nominal.factors])  # factors of damping ratios
        modes, before = eigenmodes(M, K, first_order), built.drawn
        drawn = modes if before is None else eigenmodes(before.mass, before.stiffness, first_order)
        more = more_damping(nominal, drawn, *((M, C) if before is None else (before.mass, before.damping)), own)
        if nominal.turns and any(isinstance(candidate, ChangeCandidate) for candidate in self.candidates):
            turned = 0.5 * (1 + theta[:, nominal.values, None, None])
            more = (1 - turned) * more + turned * more_damping(nominal, modes, M, C, own)
        carried = self._carried(theta)
        shapes, trailing = np.broadcast_to(basis.shapes, (len(theta), *basis.shapes.shape)), None
        if self.size < M.shape[1]:
            T = aligned_modes(modes, self.size)
            if nominal.has_dashpots or any(isinstance(c, DashpotCandidate) for c in self.candidates):
                trailing = trailing_of(modes, T, C + more + dashpots, basis.shapes)
            M, C, K, more, dashpots = (T.transpose(0, 2, 1) @ matrix @ T for matrix in (M, C, K, more, dashpots))
            shapes, carried = basis.shapes @ T, T.transpose(0, 2, 1) @ carried
        C = C + more
        C = C + assumed_damping(nominal, M, C, K, own, self._replaced(theta), first_order) + dashpots
        if nominal.disperses:
            K = dispersed(M, K, theta[:, nominal.dispersion], nominal.rate)
        return ReducedModel(M, C, K, shapes, carried, trailing)

    def _built(self, theta: FloatArray) -> _Built:
        """Return the matrices of ``theta`` (variant, parameter), but for the damping of modes."""
        nominal, basis = self.nominal, self.basis
        parts, of_mass = len(nominal.parts), self._of_mass
        factor = np.exp(theta[:, :parts])
        M = self._drawn_mass(factor)
        C, K = (np.repeat(matrix[None], len(theta), axis=0) for matrix in (basis.damping, basis.stiffness))
        K += np.tensordot(factor[:, ~of_mass] - 1, basis.parts[~of_mass], axes=1)
        K += np.tensordot(theta[:, nominal.factors : nominal.values], basis.scattered, axes=1)
        rayleigh = nominal.structure.damping
        C += rayleigh.mass_factor * (M - basis.mass) + rayleigh.stiffness_factor * (K - basis.stiffness)
        before, altered, dashpots = (M, C, K), False, np.zeros_like(C)
        alike = bool((theta == theta[0])[:, : self.nuisances].all())
        for candidate, change, part in self._matrix_candidates:
            amount = candidate.amount(theta[:, part.start])
            if isinstance(candidate, ChangeCandidate) and candidate.part is not None:
                amount = amount * factor[:, candidate.part]
            dM, dC, dK = amount[:, None, None] * change[:, None]
            if isinstance(candidate, DashpotCandidate):
                dashpots = dashpots + dC
                continue
            M, C, K = M + dM, C + dC, K + dK  # the structure's own damping there
            if isinstance(candidate, SupportCandidate):  # without it there are other modes
                before, alike = (before[0] + dM, before[1] + dC, before[2] + dK), False
            else:
                altered = True
        one = slice(1) if alike else slice(None)
        return _Built(M, C, K, dashpots, _Drawn(*(matrix[one] for matrix in before)) if altered else None)

    @cached_property
    def residual(self) -> ResidualModes | None:
        """What gives way to the nominal model's laws and the candidates' in the modes that are not followed."""
        nominal = self.nominal
        return residual_modes_of(nominal, [nominal.pull(law) for law in nominal.laws] + [law.pull for law in self.laws])

    @cached_property
    def left_out(self) -> list[FloatArray]:
        """How far a unit of each candidate's harmonic force bends modes that are not followed (dof,)."""
        nominal, nothing = self.nominal, np.zeros(len(self.nominal.dofs))
        return [nominal.left_out(c.pull) if isinstance(c, HarmonicCandidate) else nothing for c in self.candidates]
