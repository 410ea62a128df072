"""The basis in which a structure is searched: a chain's degrees of freedom, or a frame's first natural modes."""

from dataclasses import replace

import numpy as np
from scipy.sparse.linalg import SuperLU

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, raise_faults
from fe_models.linear import LinearModel, ModalModel
from fe_models.mode_count import mode_count
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset
from fe_models.structure import Spring, Structure
from hybrid.diagnosis.nominal.config import NOMINAL


def basis_of(dataset: Dataset, linear: LinearModel, highest: float) -> tuple[FloatArray, int | None]:
    """Return the basis (dof, vector) and how many of its modes are followed: those that the recordings can show."""
    assert isinstance(dataset.model, Structure)  # its caller has seen to that
    free = len(linear.dofs.free_rows)
    if dataset.model.is_chain:
        massless = linear.dofs.node[linear.dofs.free_rows][linear.mass.diagonal() <= 0]
        raise_faults(f"model: node {node} has no mass: give it a point mass, or join its springs" for node in massless)
        _require_no_rigid_link(dataset.model, linear, dataset.sampling_rate)
        return linear.dofs.expand(np.eye(free)), None
    modal, kept = followed_modes(dataset, linear, highest)
    return modal.shapes, kept


def _require_no_rigid_link(chain: Structure, linear: LinearModel, rate: float) -> None:
    """Raise `InputError` where a spring is rigid to recordings sampled at ``rate`` (Hz): nothing can be told of it.

    The highest natural frequency is at least that of any one mass while all others are held.
    """
    every = np.sqrt(linear.stiffness.diagonal() / linear.mass.diagonal()) / (2 * np.pi)
    alone, node = every.max(), int(linear.dofs.node[linear.dofs.free_rows][every.argmax()])
    if alone <= NOMINAL.max_samples_below * rate:
        return
    joined = [
        (number, element)
        for number, element in enumerate(chain.elements, start=1)
        if isinstance(element, Spring) and node in element.nodes
    ]
    number, stiffest = max(joined, key=lambda item: item[1].stiffness)
    raise InputError(
        f"model: element {number} ({stiffest.stiffness:.3g} N/m) makes natural frequencies of {alone:.3g} Hz and more;"
        f" to recordings at {rate:g} Hz it is rigid: give the nodes that it joins as one, with the sum of their masses,"
        f" or check the mass at node {node}"
    )


def followed_modes(
    dataset: Dataset,
    linear: LinearModel,
    highest: float,
    factors: SuperLU | None = None,
    most: int | None = None,
) -> tuple[ModalModel, int]:
    """Return the modes that recordings can show up to ``highest`` (Hz), with some beyond, and how many can be shown.

    ``factors`` of K, where they are known; ``most``: as many modes at most, those beyond counted.
    """
    weighty = mode_count(linear)
    free = min(weighty, most or weighty)
    count = min(most or NOMINAL.extra_modes, free)
    modal = natural_modes(linear, count, factors)
    while modal.frequencies[-1] < highest and count < free:
        count = min(2 * count, free)
        modal = natural_modes(linear, count, factors)
    wished, passed = dataset.assumptions.modes, min(dataset.lowpass or np.inf, dataset.sampling_rate / 2)
    kept = max(int(np.sum(modal.frequencies < (passed if wished else highest))), wished or 1)
    if most is not None and free < weighty:
        kept = min(kept, max(most - NOMINAL.extra_modes, 1))
    wanted = min(kept + NOMINAL.extra_modes, free)
    if wanted > count:
        modal = natural_modes(linear, wanted, factors)
    first = slice(None, wanted)
    modal = replace(modal, omega=modal.omega[first], damping_ratio=modal.damping_ratio[first])
    return replace(modal, shapes=modal.shapes[:, first]), min(kept, wanted)
