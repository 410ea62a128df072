"""The modal model that a user simulates with instead of the structure's own, as the nominal model."""

from dataclasses import replace

import numpy as np
from scipy.linalg import qr
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array, diags_array, eye_array

from fe_models.arrays import TINY, FloatArray
from fe_models.assembly import linearise
from fe_models.errors import InputError
from fe_models.modes import mac
from fe_models.nominal import nominal_modes
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.diagnosis.nominal.config import NOMINAL
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.scatter import NO_SCATTER


def modal_model_of(nominal: NominalModel, dataset: Dataset) -> NominalModel | None:
    """Return the nominal model of a dataset's modal model, None without one; ``nominal`` is that of its structure.

    With a left inverse P of the shapes Phi (dof, mode), M = P^T P, C = P^T diag(2 xi omega) P and
    K = P^T diag(omega^2) P have these modes, and no others. What the user is uncertain of changes it as it changes the
    structure: see `standing_for`. The structure's own force laws act on it. `InputError` where its shapes depend on
    each other.
    """
    given = dataset.assumptions.modal_model
    if given is None:
        return None
    if dataset.lowpass is not None:  # as the structure, a chain in all its modes, a frame up to where something passes
        dataset = replace(dataset, lowpass=None if nominal.is_chain else nominal.highest)
    modal = nominal_modes(dataset, len(given.omega))
    shapes = _normalised(modal.shapes, nominal)
    P = _left_inverse(shapes)
    count = len(modal.omega)
    as_matrix = modal.damping_ratio if nominal.turns else np.zeros(count)  # else each mode has its ratio, as there
    diagonals = np.ones(count), 2 * as_matrix * modal.omega, modal.omega**2
    mass, damping, stiffness = (P.T @ diags_array(values) @ P for values in diagonals)
    normal = np.maximum(dataset.assumptions.uncertainty.damping, NOMINAL.least_std)
    asked = nominal.spread[: len(nominal.parts)], np.full(count, normal), nominal.spread[nominal.values :]
    modal_alone = replace(
        nominal,
        mass=csr_array(mass),
        damping=csr_array(damping),
        stiffness=csr_array(stiffness),
        basis=shapes,
        kept=None,
        ratios=(modal.damping_ratio - as_matrix)[np.argsort(modal.omega)],
        scatter=NO_SCATTER,
        spread=np.concatenate(asked),
    )
    T = standing_for(nominal, modal_alone)
    return replace(modal_alone, part_changes=tuple(csr_array(T.T @ change @ T) for change in nominal.part_changes))


def standing_for(nominal: NominalModel, modal: NominalModel) -> csr_array:
    """Return T (dof, dof) from a motion in the modal model's shapes to the same in those of the structure's own modes.

    T^T dK T is what a changed part of a frame does to the modal model, its modes standing for the structure's.
    Phi^T dK Phi with its own shapes is not: errors of a shape from one node to the next bend a beam far more than the
    mode does. A chain's springs stretch by as much as its nodes move, and take the shapes as they are.
    """
    if nominal.is_chain:
        return csr_array(eye_array(len(nominal.dofs)))
    own_shapes, shapes = nominal.modes[1], modal.basis
    own, given, _ = pairs(own_shapes, shapes, nominal)
    sign = np.sign(np.einsum("di,di->i", own_shapes[:, own], shapes[:, given]))
    matched = np.zeros_like(shapes)
    matched[:, given] = own_shapes[:, own] * sign
    return csr_array(matched) @ _left_inverse(shapes)


def with_ratios_of_modal_model(dataset: Dataset) -> Dataset:
    """Return the dataset with the modal model's damping ratios for a structure that says nothing of damping."""
    modal, structure = dataset.assumptions.modal_model, dataset.model
    if modal is None or dataset.assumptions.damping_ratio is not None or not isinstance(structure, Structure):
        return dataset
    linear = linearise(structure)
    if linear.has_modal_damping or linear.damping.count_nonzero():
        return dataset
    ratios = modal.damping_ratio[np.argsort(modal.omega)]
    ratios = np.pad(ratios, (0, max(len(modal.dofs) - len(ratios), 0)), mode="edge")
    assumptions = replace(dataset.assumptions, damping_ratio=tuple(float(ratio) for ratio in ratios))
    return replace(dataset, assumptions=assumptions)


def pairs(own: FloatArray, given: FloatArray, nominal: NominalModel) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return which of the shapes ``own`` (dof, i) and ``given`` (dof, j) belong together, (pair,) each, and their MAC.

    All in all as alike as can be: a modal model may have its modes in any order, and fewer or more of them.
    """
    moving = nominal.dofs.free & (nominal.dofs.direction != "rz")  # rotations are no lengths
    alike = mac(own[moving], given[moving])
    first, second = linear_sum_assignment(-alike)
    return first, second, alike[first, second]


def _normalised(shapes: FloatArray, nominal: NominalModel) -> FloatArray:
    """Return the shapes (dof, mode) normalised by the structure's mass, whatever they were normalised by."""
    shapes = shapes * nominal.dofs.free[:, None]  # what is all but zero at the supports
    count = shapes.shape[1]
    size = np.sqrt(np.einsum("di,di->i", shapes, nominal.mass @ shapes))
    length = np.linalg.norm(shapes, axis=0)
    R = qr(shapes.T / np.maximum(length, TINY)[:, None], mode="r", pivoting=True)[0]
    if (
        (size == 0).any()
        or len(shapes) < count
        or abs(R[count - 1, count - 1]) < NOMINAL.min_independent_share * abs(R[0, 0])
    ):
        raise InputError(
            f"[simulation] modal_model: the {count} shapes that are used depend on each other: each mode must be given"
            f" once, move masses, and there are {len(nominal.dofs.free_rows)} modes at most"
        )
    return np.asarray(shapes / size)


def _left_inverse(shapes: FloatArray) -> csr_array:
    """Return P (mode, dof), P Phi = I for ``shapes`` Phi (dof, mode).

    It takes as many degrees of freedom as there are modes, those that distinguish them best, so that it stays sparse.
    """
    count = shapes.shape[1]
    rows = qr(shapes.T, mode="r", pivoting=True)[1][:count]
    columns = csr_array((np.ones(count), (np.arange(count), rows)), shape=(count, len(shapes)))
    return csr_array(csr_array(np.linalg.inv(shapes[rows])) @ columns)
