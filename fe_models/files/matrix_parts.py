"""A linear model from matrices and the places of their rows, whatever file these come from; all faults at once."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import get_args

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray, IntArray
from fe_models.dof_map import DofMap
from fe_models.errors import InputError, raise_faults
from fe_models.linear import LinearModel, MatrixGroup
from fe_models.linear_checks import check_linear_model, energy_faults
from fe_models.rigid_links import Linked, rigidly_linked
from fe_models.structure import Direction

Dof = tuple[int, str]
DIRECTIONS = get_args(Direction)


@dataclass(frozen=True)
class MatrixParts:
    """What a file of matrices holds: ``mass``, ``stiffness`` and ``damping`` (row, row), ``nodes`` (node, 2 or 3) in m,
    ``dofs``, the node and direction of each row; ``everywhere``: the same of all, held ones included, None where no
    others are known. ``rigid_links`` (link, 2): numbers of a node that leads and of one that follows it; ``linked``:
    other degrees of freedom that follow rows. For the rest see `LinearModel`.
    """

    mass: csr_array
    stiffness: csr_array
    nodes: FloatArray
    dofs: list[Dof]
    damping: csr_array | None = None
    everywhere: list[Dof] | None = None
    modal_ratios: FloatArray | None = None
    replaced_ratios: FloatArray | None = None
    groups: tuple[MatrixGroup, ...] = ()
    lines: IntArray | None = None
    rigid_links: IntArray | None = None
    linked: Linked = field(default_factory=Linked)


def assemble_model(where: str, parts: MatrixParts) -> LinearModel:
    """Return the model, checked as every linear model is."""
    dofs, everywhere = parts.dofs, parts.dofs if parts.everywhere is None else parts.everywhere
    faults, free = _dof_faults(everywhere), set(dofs)
    places = [dof for dof in everywhere if dof in free] if everywhere is not dofs else dofs
    if places != dofs:
        raise InputError(f"{where}: all_dof_node and all_dof_direction must hold those of dof_*, in the same order")
    raise_faults(f"{where}: {fault}" for fault in faults)
    linked = parts.linked
    if parts.rigid_links is not None and len(parts.rigid_links):
        found, wrong = rigidly_linked(parts.rigid_links, parts.nodes, dofs, everywhere)
        faults += wrong
        linked = linked.and_those_of(found)
    faults += linked.faults(everywhere, len(dofs))
    raise_faults(f"{where}: {fault}" for fault in faults)
    pairs = _replaced(parts.replaced_ratios, faults)
    ratios = () if parts.modal_ratios is None else tuple(parts.modal_ratios.ravel().tolist())
    faults += _ratio_faults("modal_ratios", ratios, -1) + _ratio_faults("replaced_ratios", [xi for _, xi in pairs], 0)
    model = LinearModel(
        parts.mass,
        csr_array(parts.mass.shape) if parts.damping is None else parts.damping,
        parts.stiffness,
        linked.joined(_dof_map(everywhere, free), len(dofs)),
        parts.nodes,
        ratios,
        pairs,
        parts.groups,
        parts.lines,
    )
    names = Counter(group.name for group in parts.groups)
    faults += [f"group {name!r} is given {count} times" for name, count in names.items() if count > 1]
    faults += check_linear_model(model)
    raise_faults(f"{where}: {fault}" for fault in faults or energy_faults(model))
    return model


def _dof_map(everywhere: list[Dof], free: set[Dof]) -> DofMap:
    return DofMap(
        node=np.array([node for node, _ in everywhere], dtype=np.int64),
        direction=np.array([direction for _, direction in everywhere], dtype=np.str_),
        free=np.array([dof in free for dof in everywhere], dtype=bool),
    )


def _replaced(table: FloatArray | None, faults: list[str]) -> tuple[tuple[int, float], ...]:
    if table is None:
        return ()
    if table.ndim != 2 or table.shape[1] != 2 or not np.isfinite(table).all():
        faults.append(f"replaced_ratios is no table of mode and ratio; it has shape {table.shape}")
        return ()
    faults += [
        f"replaced_ratios: there is no mode {mode:g}; they are numbered from 1" for mode in table[:, 0] if mode < 1
    ]
    return tuple((int(mode), float(ratio)) for mode, ratio in table)


def _ratio_faults(name: str, ratios: Iterable[float], least: int) -> list[str]:
    """Return a fault for each number that is no damping ratio; one below 0 takes away from what C gives."""
    wrong = [ratio for ratio in ratios if not (least < ratio < 1 or ratio == 0)]
    return [f"{name}: {ratio:g} is no damping ratio; expected {least} <= ratio < 1 (0.01 is 1 %)" for ratio in wrong]


def _dof_faults(dofs: list[Dof]) -> list[str]:
    times = Counter(dofs)
    faults = [f"node {node} {direction} appears {n} times" for (node, direction), n in times.items() if n > 1]
    unknown = sorted({direction for _, direction in dofs} - set(DIRECTIONS))
    expected = ", ".join(DIRECTIONS[:-1])
    return faults + [f"direction {name!r} is unknown; expected {expected} or {DIRECTIONS[-1]}" for name in unknown]
