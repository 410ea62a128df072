"""The nominal structure with what its user considers uncertain, in a basis of natural modes where it is a frame.

`structure_model` makes it of a structure, `grouped_model` of matrices.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_array, vstack
from scipy.sparse.linalg import SuperLU

from fe_models.arrays import TINY, FloatArray
from fe_models.assembly import linearise
from fe_models.base_motion import base_force, rigid_motion
from fe_models.causes import Effect, ForceLaw, MemorylessLaw, TimeIntegration
from fe_models.causes.candidate import Changes
from fe_models.causes.laws import with_parts
from fe_models.damping import ratios_of_modes
from fe_models.dof_map import DofMap
from fe_models.lowpass import LowPass
from fe_models.matrix_changes import matrix_changes
from fe_models.mechanisms import factorise
from fe_models.modes import natural_modes
from fe_models.recordings import Sensor
from fe_models.sensing import seen
from fe_models.structure import Structure
from fe_models.uncertain_parts import UncertainPart
from hybrid.diagnosis.nominal.config import NOMINAL
from hybrid.diagnosis.nominal.coordinates import Coordinates
from hybrid.diagnosis.nominal.geometry import Geometry
from hybrid.diagnosis.nominal.loads import KnownPlace, OnBase
from hybrid.diagnosis.nominal.scatter import Scatter


@dataclass(frozen=True)
class NominalModel:
    """A structure and the basis in which it is searched.

    ``mass``, ``damping``, ``stiffness``: sparse (dof, dof) over all degrees of freedom, as if no support held it.
    ``basis`` (dof, vector): a chain's free degrees of freedom, or a frame's first natural modes. ``kept``: number of
    modes whose motion is followed, those up to the ``highest`` frequency (Hz) that recordings behind a ``lowpass``
    (None without) show, if nothing else is asked for; the others only bend along with them; None: all. ``parts``: what
    is uncertain as a whole, and ``part_changes`` (dof, dof): what the doubling of each adds to M or K. ``ratios``:
    modal damping ratios (mode,), assumed or the structure's, on top of ``damping``, of the modes kept and of one that a
    cause may bring: each mode has its own, whatever causes make of its shape. ``scatter``: how elements are off by
    themselves. ``spread``: prior standard deviations of the log factors of parts and damping ratios, of the scatter's
    patterns, of the damping's `NOMINAL.damping_turn_std`, where it ``turns``, as the structure has a damping matrix of
    its own, and of the `dispersion`, where it ``disperses``, in this order (nuisance,). ``laws``: forces that the
    nominal structure itself has. ``integration``: the error of the user's own time steps, None where it integrates
    exactly. ``loaded``: where recordings are loaded, or shaken. ``geometry``: forces beyond the linear model's, None
    where there are none. ``rate``: of the recordings' samples, Hz. ``coordinates``: of matrices, what all of the above
    is over in place of degrees of freedom; None of a structure.
    """

    structure: Structure
    mass: csr_array
    damping: csr_array
    stiffness: csr_array
    dofs: DofMap
    basis: FloatArray
    kept: int | None
    parts: tuple[UncertainPart, ...]
    part_changes: tuple[csr_array, ...]
    ratios: FloatArray
    scatter: Scatter
    spread: FloatArray
    laws: tuple[MemorylessLaw, ...]
    integration: TimeIntegration | None
    loaded: tuple[KnownPlace, ...] = ()
    geometry: Geometry | None = None
    highest: float = np.inf
    lowpass: LowPass | None = None
    rate: float = np.inf
    turns: bool = False
    disperses: bool = False
    coordinates: Coordinates | None = None

    @property
    def size(self) -> int:
        """Number of modes that are followed."""
        return self.basis.shape[1] if self.kept is None else self.kept

    @property
    def followed_shapes(self) -> FloatArray:
        """The first vectors of the ``basis``, (dof, mode): as many as are followed."""
        return self.basis[:, : self.size]

    @property
    def is_chain(self) -> bool:
        """Whether all is springs and masses in one direction."""
        return self.structure.is_chain

    @cached_property
    def has_dashpots(self) -> bool:
        """Whether the nominal structure has dashpots, drawn or as effects."""
        return bool(with_parts(self.structure).dashpots)

    @property
    def alike(self) -> float:
        """Number of recorded values that are worth one independent value."""
        return 1.0 if self.is_chain else NOMINAL.frame_values_per_independent

    @property
    def factors(self) -> int:
        """Number of parts and damping ratios, whose factors are the first nuisances; the scatter's patterns follow."""
        return len(self.parts) + len(self.ratios)

    @property
    def values(self) -> int:
        """Number of nominal values that may be off: the factors, then the scatter's patterns."""
        return self.factors + len(self.scatter.changes)

    @property
    def dispersion(self) -> int:
        """Which nuisance is the dispersion, where it is one; the damping's turning comes after the values."""
        return self.values + self.turns

    @property
    def undispersed(self) -> "NominalModel":
        """The nominal model without dispersion."""
        if not self.disperses:
            return self
        return replace(self, spread=np.delete(self.spread, self.dispersion), disperses=False)

    @property
    def cutoff(self) -> float:
        """Of the low-pass, rad/s."""
        return np.inf if self.lowpass is None else 2 * np.pi * self.lowpass.cutoff

    @cached_property
    def below(self) -> int:
        """Number of nominal modes that are followed and lie below the low-pass."""
        return int(np.sum(self.modes[0] < self.cutoff))

    @property
    def matrices(self) -> tuple[csr_array, ...]:
        """M, C, K, then what doubling each part adds and what a unit of each pattern of the scatter does."""
        return (self.mass, self.damping, self.stiffness, *self.part_changes, *self.scatter.changes)

    @cached_property
    def stacked(self) -> csr_array | FloatArray:
        """The ``matrices`` one below the other, (matrix times dof, dof); an array where they are full, as large ones in
        few coordinates are.
        """
        found = csr_array(vstack(self.matrices))
        return found.toarray() if found.nnz > NOMINAL.full_share * len(self.dofs) * found.shape[0] else found

    @cached_property
    def projected(self) -> FloatArray:
        """The ``matrices`` in the basis, (matrix, vector, vector)."""
        return np.stack([self.basis.T @ (matrix @ self.basis) for matrix in self.matrices])

    @cached_property
    def modes(self) -> tuple[FloatArray, FloatArray]:
        """Natural frequencies (rad/s) and mass-normalised shapes (dof, mode) of the nominal modes that are followed."""
        return self._lowest(self.size)

    @property
    def all_frequencies(self) -> FloatArray:
        """Natural frequencies (rad/s) of all modes of the basis, those that are not followed as well."""
        return self._lowest(self.basis.shape[1])[0]

    @cached_property
    def own_ratios(self) -> FloatArray:
        """Damping ratios (mode,) of the nominal modes, of as many as there are ``ratios``."""
        omega, shapes = self._lowest(len(self.ratios))
        own = np.einsum("di,di->i", shapes, self.damping @ shapes)
        return np.asarray(own / (2 * np.maximum(omega, TINY)) + self.ratios)

    def ratios_of(self, count: int) -> FloatArray:
        """Return the modal damping ratios of ``count`` modes: causes may bring some beyond those that are uncertain."""
        given = self.structure.damping.modal_ratios or (float(self.ratios[-1]),)
        return np.append(self.ratios, ratios_of_modes(given, max(count, len(self.ratios)))[len(self.ratios) :])[:count]

    def _lowest(self, count: int) -> tuple[FloatArray, FloatArray]:
        M, _, K = self.projected[:3]
        omega2, shapes = eigh(K, M)
        return np.sqrt(np.maximum(omega2[:count], 0.0)), self.basis @ shapes[:, :count]

    def pull(self, law: ForceLaw) -> FloatArray:
        """Return the coefficients (dof,) of a law's elongation."""
        return self.dofs.pull(law.pulls)

    def changes_of(self, effect: Effect) -> Changes:
        """Return dM, dC, dK, sparse (dof, dof), of an effect."""
        changes = matrix_changes(self.structure, effect)
        return changes.mass, changes.damping, changes.stiffness

    def frequencies_with(self, effect: Effect) -> FloatArray:
        """Return the natural frequencies (mode,), rad/s, of as many modes as are followed, of the structure with an
        effect; `InputError` where it does not stand.
        """
        return natural_modes(linearise(self.structure.with_effects(effect)), len(self.modes[0])).omega

    @cached_property
    def built(self) -> Structure:
        """The structure with its effects that are plain parts built in: what its force laws act on."""
        return with_parts(self.structure)

    @cached_property
    def load_pulls(self) -> FloatArray:
        """What a unit of each known load pulls, (load, dof); one of a base's motion, its inertia."""
        found = np.zeros((len(self.loaded), len(self.dofs)))
        for pull, place in zip(found, self.loaded, strict=True):
            if not isinstance(place, OnBase):
                pull[self.dofs.row(*place)] = 1.0
            elif place.drives:
                pull[:] = base_force(self.mass, self.dofs, place.along)
        return found

    @cached_property
    def rigid_motions(self) -> FloatArray:
        """How all degrees of freedom move with each thing known of a base, (dof, load); zero of other loads."""
        still = np.zeros(len(self.dofs))
        moved = [rigid_motion(self.dofs, at.along) if isinstance(at, OnBase) else still for at in self.loaded]
        return np.array(moved).reshape(-1, len(self.dofs)).T

    @cached_property
    def load_shapes(self) -> FloatArray:
        """How modes that are not followed move under a unit of each known load, (term, dof, load).

        Below their natural frequencies omega as the series of 1 / (omega^2 + s^2) says: the first term of the load, the
        next ones of its second and fourth derivative (the force derivative method of Leung, 1983).
        """
        terms = [np.stack([self.left_out(pull) for pull in self.load_pulls], axis=-1)]
        while len(terms) < NOMINAL.load_terms:
            terms.append(-self._beyond(self.static(self.mass @ terms[-1])))
        return np.stack(terms)

    def rows(self, sensors: tuple[Sensor, ...]) -> FloatArray:
        """Return what each sensor picks of the degrees of freedom, (sensor, dof)."""
        if sensors not in self._rows:
            self._rows[sensors] = (
                seen(self.dofs, sensors) if self.coordinates is None else self.coordinates.seen(sensors)
            )
        return self._rows[sensors]

    def static(self, forces: FloatArray) -> FloatArray:
        """Return the displacements (dof, load) under ``forces`` (dof, load), supports holding."""
        return self.dofs.expand(self._factors.solve(np.asarray(forces)[self.dofs.free]))

    def left_out(self, pull: FloatArray) -> FloatArray:
        """Return how far a unit force along ``pull`` (dof,) bends modes that are not followed, (dof,)."""
        if self.kept is None:
            return np.zeros(len(self.dofs))
        return self._beyond(self.static(pull[:, None])[:, 0])

    def _beyond(self, moved: FloatArray) -> FloatArray:
        """Return the part of displacements (dof, ...) that lies in modes that are not followed."""
        shapes = self.modes[1]
        return np.asarray(moved - shapes @ (shapes.T @ (self.mass @ moved)))

    def released(self, row: int) -> FloatArray:
        """Return the displacements (dof,) when a held degree of freedom moves by one and the others stay held."""
        free = self.dofs.free_rows
        moved = -self._factors.solve(self.stiffness[free][:, [row]].toarray()[:, 0])
        shape = self.dofs.expand(moved)
        shape[row] = 1.0
        return shape

    @cached_property
    def bent_by(self) -> dict[object, FloatArray]:
        """How candidates bend the structure statically, (dof, load) by candidate, once that was asked for."""
        return {}

    @cached_property
    def _rows(self) -> dict[tuple[Sensor, ...], FloatArray]:
        """What sensors pick, once that was asked for."""
        return {}

    @cached_property
    def _factors(self) -> SuperLU:
        free = self.dofs.free_rows
        return factorise(self.stiffness[free][:, free])
