"""The modal model that a user simulates with instead of the structure's own, as a plant of its own."""

from dataclasses import replace

import numpy as np
from scipy.linalg import qr
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array, diags_array

from fe_models.assembly import linearise
from fe_models.dofs import FloatArray
from fe_models.errors import InputError
from fe_models.modes import mac
from fe_models.nominal import nominal_modes
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.diagnosis.plant import CERTAIN, Plant

DEPENDENT = 1e-6  # of the largest singular value of unit shapes: below, one of them is made of the others
TOLD = 5e-4  # of a frequency, of a damping ratio of 1, of a MAC of 1: smaller differences are not worth a word
COUPLED = 0.01  # of the product of two modes' own damping: the square of what dashpots add between them, told beyond
TINY = 1e-300  # of a shape's length or a mode's damping: instead of a division by zero


def modal_plant(plant: Plant, dataset: Dataset) -> Plant | None:
    """Return the plant of a dataset's modal model, None without one; ``plant`` is that of its structure.

    With a left inverse P of the shapes Phi (dof, mode), M = P^T P, C = P^T diag(2 xi omega) P and
    K = P^T diag(omega^2) P have these modes, and no others. What the user is uncertain of changes it as it changes the
    structure, by Phi^T dM Phi and Phi^T dK Phi; the structure's own force laws act on it. `InputError` where its shapes
    depend on each other.
    """
    given = dataset.assumptions.modal_model
    if given is None:
        return None
    if plant.is_chain:  # which is followed in all its modes, whatever a low-pass has taken away
        dataset = replace(dataset, lowpass=None)
    modal = nominal_modes(dataset, len(given.omega))
    shapes, P = _normalised(modal.shapes, plant)
    count = len(modal.omega)
    diagonals = np.ones(count), 2 * modal.damping_ratio * modal.omega, modal.omega**2
    mass, damping, stiffness = (P.T @ diags_array(values) @ P for values in diagonals)
    normal = np.maximum(dataset.assumptions.uncertainty.damping, CERTAIN)
    return replace(
        plant,
        mass=csr_array(mass),
        damping=csr_array(damping),
        stiffness=csr_array(stiffness),
        basis=shapes,
        kept=None,
        ratios=np.zeros(count),
        spread=np.append(plant.spread[: len(plant.parts)], np.full(count, normal)),
    )


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


def difference(plant: Plant, modal: Plant) -> str:
    """Return in words how far the modes of ``modal`` are from the ``plant``'s own; each beside the one most like it."""
    (own_omega, own_shapes), (omega, shapes) = plant.modes, modal.modes
    moving = plant.dofs.free & (plant.dofs.direction != "rz")
    alike = mac(own_shapes[moving], shapes[moving])  # (own, given)
    own, given = linear_sum_assignment(-alike)
    frequency = omega[given] / own_omega[own] - 1
    ratios, own_ratios = modal.own_ratios[given], plant.own_ratios[own]
    least = alike[own, given].min()
    words = []
    if len(omega) != len(own_omega):
        words.append(f"{len(omega)} modes instead of {len(own_omega)}")
    if np.abs(frequency).max() > TOLD:
        words.append(f"frequencies by {frequency.min():+.1%} to {frequency.max():+.1%}")
    if np.abs(ratios - own_ratios).max() > TOLD:
        words.append(f"damping ratios {_range(ratios)} instead of {_range(own_ratios)}")
    if least < 1 - TOLD:
        words.append(f"shapes with a MAC of {least:.3f} at least")
    if _coupling(plant) > COUPLED:
        words.append("no damping between modes, which the structure's dashpots couple")
    return ", ".join(words) or "by little in each mode"


def _coupling(plant: Plant) -> float:
    """Return the largest C_ij^2 / (C_ii C_jj) of two of a plant's modes."""
    shapes = plant.modes[1]
    C = shapes.T @ (plant.damping @ shapes)
    own = np.maximum(np.diag(C), TINY)
    return float(np.max((C - np.diag(np.diag(C))) ** 2 / np.outer(own, own)))


def _normalised(shapes: FloatArray, plant: Plant) -> tuple[FloatArray, csr_array]:
    """Return the shapes (dof, mode) normalised by the structure's mass, and P (mode, dof), P Phi = I.

    P takes as many degrees of freedom as there are modes, those that tell them apart best, so that it stays sparse.
    """
    shapes = shapes * plant.dofs.free[:, None]  # what is all but zero at the supports
    count = shapes.shape[1]
    size = np.sqrt(np.einsum("di,di->i", shapes, plant.mass @ shapes))
    length = np.linalg.norm(shapes, axis=0)
    R, order = qr(shapes.T / np.maximum(length, TINY)[:, None], mode="r", pivoting=True)
    if (size == 0).any() or len(shapes) < count or abs(R[count - 1, count - 1]) < DEPENDENT * abs(R[0, 0]):
        raise InputError(
            f"[simulation] modal_model: the {count} shapes that are used depend on each other: each mode must be given"
            f" once, move masses, and there are {len(plant.dofs.free_rows)} modes at most"
        )
    shapes, rows = shapes / size, order[:count]
    inverse = csr_array(np.linalg.inv(shapes[rows]))
    columns = csr_array((np.ones(count), (np.arange(count), rows)), shape=(count, len(shapes)))
    return shapes, csr_array(inverse @ columns)


def _range(ratios: FloatArray) -> str:
    least, most = f"{ratios.min():.2%}", f"{ratios.max():.2%}"
    return least if least == most else f"{least} to {most}"
