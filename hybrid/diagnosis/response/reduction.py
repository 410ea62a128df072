"""A hypothesis' matrices in few coordinates: natural modes, enriched with what its candidates bend statically."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate, MatrixCandidate, SupportCandidate
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response.config import REDUCTION


@dataclass(frozen=True)
class Basis:
    """``shapes`` (dof, vector), and M, C, K in it (vector, vector); ``parts`` (part, vector, vector): what doubling an
    uncertain part adds, ``scattered`` (pattern, vector, vector) what a unit of each pattern of the scatter does;
    ``changes`` (3, vector, vector) dM, dC, dK a unit of each candidate's amount, None without. ``carried`` (vector,
    load): the mass that a moving base carries along, shapes^T M r, zero of other loads; ``carried_parts`` (part,
    vector, load) and ``carried_changes`` (vector, load) what parts and candidates add to it.
    """

    shapes: FloatArray
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    parts: FloatArray
    scattered: FloatArray
    changes: tuple[FloatArray | None, ...]
    carried: FloatArray
    carried_parts: FloatArray
    carried_changes: tuple[FloatArray | None, ...]


def basis_of(nominal: NominalModel, candidates: tuple[Candidate, ...]) -> Basis:
    """Return the nominal basis with the static response to each linear candidate, mass-orthogonal to all before it.

    Exact in the limit of many modes, and already with few for a change that few forces make (Craig and Bampton's
    fixed-interface modes and constraint modes, where a support is released).
    """
    shapes = nominal.basis
    for candidate in candidates:
        known = candidate.key, candidate.width
        if known not in nominal.bent_by:  # of hundreds of hypotheses with the same candidate
            nominal.bent_by[known] = _static_shapes(nominal, candidate)
        bent = nominal.bent_by[known]
        if candidate.brings:  # so large a change that the inertia of these shapes bends them, too
            bent = np.hstack([bent, nominal.static(nominal.mass @ bent)])
        for shape in bent.T:
            shapes = _appended(shapes, shape, nominal)
    changes = tuple(
        np.array([shapes.T @ (part @ shapes) for part in c.changes]) if isinstance(c, MatrixCandidate) else None
        for c in candidates
    )
    M, C, K, *others = _projected(nominal, shapes)
    first, size = len(nominal.parts), shapes.shape[1]
    parts, scattered = (np.array(group).reshape(-1, size, size) for group in (others[:first], others[first:]))
    rigid = nominal.rigid_motions
    carried = shapes.T @ (nominal.mass @ rigid)
    of_parts = np.zeros((len(nominal.part_changes), *carried.shape))
    if rigid.any():
        of_parts[:] = [shapes.T @ (part @ rigid) for part in nominal.part_changes]
    of_candidates = tuple(
        shapes.T @ (c.changes[0] @ rigid) if isinstance(c, MatrixCandidate) else None for c in candidates
    )
    return Basis(shapes, M, C, K, parts, scattered, changes, carried, of_parts, of_candidates)


def _projected(nominal: NominalModel, shapes: FloatArray) -> FloatArray:
    """Return the nominal matrices, all symmetric, in ``shapes`` (dof, vector), the first of which are its own."""
    known = nominal.projected
    own, size = known.shape[1], shapes.shape[1]
    if size == own:
        return known
    added = (nominal.stacked @ shapes[:, own:]).reshape(len(known), len(shapes), size - own)
    full = np.empty((len(known), size, size))
    full[:, :own, :own] = known
    full[:, :, own:] = shapes.T @ added
    full[:, own:, :own] = full[:, :own, own:].swapaxes(1, 2)
    return full


def _static_shapes(nominal: NominalModel, candidate: Candidate) -> FloatArray:
    """Return the shapes (dof, load) that a candidate needs beyond the nominal model's own."""
    if isinstance(candidate, SupportCandidate):
        return nominal.released(candidate.row)[:, None]
    if nominal.kept is None or not isinstance(candidate, MatrixCandidate):
        return np.zeros((len(nominal.dofs), 0))
    if candidate.pulls is not None:
        return nominal.static(candidate.pulls)
    forces = []
    for change in candidate.changes:
        rows = np.unique(np.concatenate(change.nonzero()))
        if len(rows):
            values, vectors = np.linalg.eigh(change[rows][:, rows].toarray())
            felt = np.abs(values) > REDUCTION.min_eigenvalue_share * np.abs(values).max()
            full = np.zeros((len(nominal.dofs), int(felt.sum())))
            full[rows] = vectors[:, felt]
            local = full.shape[1] <= REDUCTION.max_local_forces
            forces.append(full if local else spread_forces(nominal, change, candidate.width[0]))
    return nominal.static(np.hstack(forces)) if forces else np.zeros((len(nominal.dofs), 0))


def spread_forces(nominal: NominalModel, change: csr_array, amount: float) -> FloatArray:
    """Return the forces (dof, load) of a spread change on those followed modes that bend most under them beyond the
    nominal model's basis, where an ``amount`` of it is felt at all: a sagging beam's bending goes with its stretching.
    """
    omega, shapes = nominal.modes
    forces = np.asarray(amount * (change @ shapes))
    bent = nominal.static(forces)
    bent = bent - nominal.basis @ (nominal.basis.T @ (nominal.mass @ bent))
    energy = np.einsum("di,di->i", bent, nominal.stiffness @ bent) / omega**2
    worst = np.argsort(-energy)[: REDUCTION.max_local_forces]
    return forces[:, worst[energy[worst] > REDUCTION.min_energy_share]]


def _appended(shapes: FloatArray, shape: FloatArray, nominal: NominalModel) -> FloatArray:
    """Return ``shapes`` (dof, vector) with one more, made orthogonal to them and normalised by mass."""
    length = float(np.sqrt(shape @ (nominal.mass @ shape)))
    rest, own, M = shape, nominal.basis.shape[1], nominal.projected[0]
    for _ in range(2):  # once leaves rounding errors of what was taken away
        along = shapes.T @ (nominal.mass @ rest)
        along[:own] = np.linalg.solve(M, along[:own])  # those that came after have a mass of one, each for itself
        rest = rest - shapes @ along
    left = float(np.sqrt(max(rest @ (nominal.mass @ rest), 0.0)))
    if length == 0 or left <= REDUCTION.min_new_length_share * length:
        return shapes
    return np.column_stack([shapes, rest / left])
