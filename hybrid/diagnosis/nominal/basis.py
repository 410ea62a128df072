"""The basis in which a structure is searched: a chain's degrees of freedom, or a frame's first natural modes."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import raise_faults
from fe_models.linear import LinearModel
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.diagnosis.nominal.config import NOMINAL


def basis_of(dataset: Dataset, linear: LinearModel, highest: float) -> tuple[FloatArray, int | None]:
    """Return the basis (dof, vector) and how many of its modes are followed: those that the recordings can show."""
    assert isinstance(dataset.model, Structure)  # its caller has seen to that
    free = len(linear.dofs.free_rows)
    if dataset.model.is_chain:
        massless = linear.dofs.node[linear.dofs.free_rows][linear.mass.diagonal() <= 0]
        raise_faults(f"model: node {node} has no mass: give it a point mass, or join its springs" for node in massless)
        return linear.dofs.expand(np.eye(free)), None
    count = min(NOMINAL.extra_modes, free)
    modal = natural_modes(linear, count)
    while modal.frequencies[-1] < highest and count < free:
        count = min(2 * count, free)
        modal = natural_modes(linear, count)
    wished, passed = dataset.assumptions.modes, min(dataset.lowpass or np.inf, dataset.sampling_rate / 2)
    kept = max(int(np.sum(modal.frequencies < (passed if wished else highest))), wished or 1)
    wanted = min(kept + NOMINAL.extra_modes, free)
    if wanted > count:
        modal = natural_modes(linear, wanted)
    return modal.shapes[:, :wanted], min(kept, wanted)
