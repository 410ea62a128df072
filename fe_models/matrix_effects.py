"""What linear effects do to matrices by groups: dM, dC and dK over the free degrees of freedom, of low rank or a share.

A group's change is (factor - 1) times its share; what acts at nodes is b b^T, with b (free,) the elongation's
coefficients, of nodes that follow others by a rigid link, too.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.causes import AddedMass, Effect, MassChange, PointDamper, StiffnessChange, SupportSpring
from fe_models.causes.known import outer
from fe_models.errors import InputError, raise_faults
from fe_models.linear import LinearModel, MatrixGroup
from fe_models.structure import TRANSLATIONS

Changes = tuple[csr_array, csr_array, csr_array]
KINDS = (StiffnessChange, MassChange, AddedMass, SupportSpring, PointDamper)


def model_with_effects(model: LinearModel, *effects: Effect) -> LinearModel:
    """Return the model with ``effects`` in its matrices, and in its groups' shares; `InputError` with all faults."""
    raise_faults(fault for effect in effects for fault in effect_faults(model, effect))
    for effect in effects:
        dM, dC, dK = matrix_changes_of(model, effect)
        groups = tuple(_scaled(group, effect) for group in model.groups)
        model = replace(
            model,
            mass=csr_array(model.mass + dM),
            damping=csr_array(model.damping + dC),
            stiffness=csr_array(model.stiffness + dK),
            groups=groups,
        )
    return model


def matrix_changes_of(model: LinearModel, effect: Effect) -> Changes:
    """Return dM, dC and dK, sparse (free, free), of one effect; `InputError` where it does not fit."""
    raise_faults(effect_faults(model, effect))
    nothing = csr_array(model.mass.shape)
    match effect:
        case StiffnessChange(group=name, factor=float() | int() as factor):
            return nothing, nothing, csr_array((factor - 1) * group_named(model, name).stiffness)
        case MassChange(group=name, factor=factor):
            return csr_array((factor - 1) * group_named(model, name).mass), nothing, nothing
        case AddedMass(node=node, mass=mass):
            return csr_array(mass * mass_pattern(model, node)), nothing, nothing
        case SupportSpring(node=node, direction=direction, stiffness=stiffness):
            return nothing, nothing, csr_array(stiffness * outer(pull_of(model, ((node, direction, 1.0),))))
        case PointDamper(nodes=nodes, direction=direction, coefficient=coefficient):
            ends = [(node, direction, sign) for node, sign in zip(nodes[::-1], (1.0, -1.0), strict=False)]
            return nothing, csr_array(coefficient * outer(pull_of(model, ends))), nothing
    raise InputError(f"{effect.kind}: {_not_for_matrices()}")


def pull_of(model: LinearModel, pulls: Sequence[tuple[int, str, float]]) -> FloatArray:
    """Return the coefficients (free,) of an elongation; `KeyError` where the model has no such degree of freedom."""
    return model.dofs.gathered(model.dofs.pull(pulls))


def mass_pattern(model: LinearModel, node: int) -> csr_array:
    """Return what a mass of 1 kg at a node adds to M (free, free): at all its translations."""
    dofs = model.dofs
    rows = np.flatnonzero((dofs.node == node) & np.isin(dofs.direction, TRANSLATIONS) & dofs.moves)
    total = csr_array(model.mass.shape)
    for row in rows:
        total = total + outer(pull_of(model, ((node, str(dofs.direction[row]), 1.0),)))
    return csr_array(total)


def group_named(model: LinearModel, name: str) -> MatrixGroup:
    """Return the group of that name; `InputError` where there is none."""
    for group in model.groups:
        if group.name == name:
            return group
    have = ", ".join(group.name for group in model.groups) or "none"
    raise InputError(f"there is no group {name!r}; the groups are: {have}")


def effect_faults(model: LinearModel, effect: Effect) -> list[str]:
    """Return what of an effect does not fit the matrices, a line each."""
    if not isinstance(effect, KINDS):
        return [f"{effect.kind}: {_not_for_matrices()}"]
    faults = [*effect.type_faults(), *effect.number_faults()]
    if isinstance(effect, StiffnessChange | MassChange):
        faults += _group_faults(model, effect)
    else:
        direction = getattr(effect, "direction", None)
        nodes = effect.nodes if isinstance(effect, PointDamper) else (effect.node,)
        faults += [fault for node in nodes for fault in _place_faults(model, node, direction)]
    return [f"{effect.kind}: {fault}" for fault in faults]


def _group_faults(model: LinearModel, effect: StiffnessChange | MassChange) -> list[str]:
    if effect.elements or not effect.group:
        return ["matrices have groups, no elements: give group = ..."]
    if isinstance(effect.factor, tuple):
        return [f"factor lists {len(effect.factor)} values; a group has one"]
    faults = [] if effect.factor >= 0 else [f"factor = {effect.factor}; must not be negative"]
    have = [group.name for group in model.groups]
    if effect.group not in have:
        return [*faults, f"there is no group {effect.group!r}; the groups are: {', '.join(have) or 'none'}"]
    return faults


def _place_faults(model: LinearModel, node: int, direction: str | None) -> list[str]:
    dofs = model.dofs
    here = (dofs.node == node) & dofs.moves
    if not 1 <= node <= len(model.coordinates):
        return [f"node {node} does not exist; the nodes are 1 to {len(model.coordinates)}"]
    if direction is None:
        movable = np.isin(dofs.direction[here], TRANSLATIONS).any()
        return [] if movable else [f"node {node} does not move"]
    if direction not in dofs.direction[here]:
        return [f"node {node} does not move in {direction}; it moves in {', '.join(dofs.direction[here]) or 'none'}"]
    return []


def _scaled(group: MatrixGroup, effect: Effect) -> MatrixGroup:
    """Return a group as an effect leaves it."""
    if isinstance(effect, StiffnessChange) and effect.group == group.name and isinstance(effect.factor, float | int):
        return replace(group, stiffness=csr_array(effect.factor * group.stiffness))
    if isinstance(effect, MassChange) and effect.group == group.name:
        return replace(group, mass=csr_array(effect.factor * group.mass))
    return group


def _not_for_matrices() -> str:
    return f"matrices alone do not say what it acts on; they take {', '.join(kind.kind for kind in KINDS)}"
