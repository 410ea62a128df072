"""Matrices of any size in few coordinates: natural modes, and static shapes of what is looked for.

A small model keeps its degrees of freedom. A large one is projected (Rayleigh and Ritz) on the modes Phi that
recordings can show and some beyond, and on how it gives way to a force at each place where a cause is sought and to
what a change of each group does to those modes, K^-1 (K_g Phi). Shapes beyond the modes are orthogonal to these by mass
and stiffness, and to one another by stiffness, so that no rounding error grows.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array, vstack
from scipy.sparse.linalg import SuperLU

from fe_models.arrays import FloatArray, IntArray
from fe_models.dof_map import DofMap
from fe_models.linear import LinearModel, MatrixGroup, ModalModel
from fe_models.mechanisms import factorise
from fe_models.recordings import Sensor
from fe_models.structure import TRANSLATIONS
from hybrid.diagnosis.nominal.config import COORDINATES

Dof = tuple[int, str]


@dataclass(frozen=True)
class Coordinates:
    """``model``: the matrices over the coordinates; ``drawn``: those of the user, over all degrees of freedom
    (both scaled alike, once they are).
    ``pulls``: how the places of sensors and of causes move with each coordinate, (coordinate,) each. ``nodes``: at
    which causes are sought, each with those that it stands for, as they move like it; ``masses``: what each weighs, kg,
    of ``whole_mass``.
    """

    model: LinearModel
    drawn: LinearModel
    pulls: dict[Dof, FloatArray]
    nodes: dict[int, tuple[int, ...]]
    masses: dict[int, float]
    whole_mass: float

    def pull(self, node: int, direction: str) -> FloatArray:
        """Return how a place moves with each coordinate, (coordinate,)."""
        return self.pulls[node, direction]

    def seen(self, sensors: Sequence[Sensor]) -> FloatArray:
        """Return what each sensor shows of each coordinate, (sensor, coordinate)."""
        still = np.zeros(self.model.mass.shape[0])  # in a component that the model has no degree of freedom for
        rows = [
            sum(part * self.pulls.get((sensor.node, axis), still) for axis, part in sensor.components.items())
            for sensor in sensors
        ]
        return np.array(rows)

    def directions(self, node: int) -> list[str]:
        """Return the translations in which a node moves."""
        return [axis for axis in TRANSLATIONS if (node, axis) in self.pulls]

    @property
    def placed(self) -> LinearModel:
        """The ``model`` with the places of sensors and of causes as degrees of freedom that follow the coordinates."""
        nodes, directions = zip(*self.pulls, strict=True)
        own, followers = len(self.model.dofs), csr_array(np.array(list(self.pulls.values())))
        dofs = DofMap(
            np.append(np.ones(own, dtype=np.int64), nodes),
            np.append(self.model.dofs.direction, directions),
            np.arange(own + len(nodes)) < own,
            csr_array(vstack([csr_array((own, own)), followers])),
        )
        return replace(self.model, dofs=dofs, coordinates=self.drawn.coordinates)

    def scaled(self, quantities: Sequence[tuple[str, str, float]]) -> "Coordinates":
        """Return the coordinates with groups' shares so many times as large: quantity, name of the group, factor."""
        return replace(self, model=_scaled(self.model, quantities), drawn=_scaled(self.drawn, quantities))


def coordinates_of(
    model: LinearModel, modal: ModalModel, followed: int, sensors: Sequence[Sensor], factors: SuperLU | None = None
) -> Coordinates:
    """Return few coordinates of matrices whose lowest modes are ``modal``, the first ``followed`` of which are seen in
    recordings; ``factors`` of K, where they are known.
    """
    shapes, omega = modal.shapes, modal.omega
    nodes = _nodes_to_search(model.dofs, shapes[:, :followed])
    known = set(zip(model.dofs.node.tolist(), model.dofs.direction.tolist(), strict=True))
    places = {(sensor.node, str(axis)) for sensor in sensors for axis in sensor.components} & known
    moving = model.dofs.moves
    sought = np.isin(model.dofs.node, list(nodes)) & moving & np.isin(model.dofs.direction, TRANSLATIONS)
    causes = [(int(model.dofs.node[row]), str(model.dofs.direction[row])) for row in np.flatnonzero(sought)]
    free = len(model.dofs.free_rows)
    if free <= COORDINATES.most_whole:
        basis = np.eye(free)
    else:
        factors = factors or factorise(model.stiffness)
        basis = _enriched(model, factors, shapes[model.dofs.free], omega, followed, causes)
    units = {place: model.dofs.row(*place) for place in sorted(places | set(causes))}
    pulls = {place: _row_of(model.dofs, row, basis) for place, row in units.items()}
    masses, whole = _masses(model, shapes, list(nodes))
    return Coordinates(_projected(model, basis), model, pulls, nodes, masses, whole)


def _scaled(model: LinearModel, quantities: Sequence[tuple[str, str, float]]) -> LinearModel:
    for quantity, name, factor in quantities:
        own = next(group for group in model.groups if group.name == name)
        share = csr_array((factor - 1) * getattr(own, quantity))
        changed = replace(own, **{quantity: csr_array(getattr(own, quantity) + share)})
        groups = tuple(changed if group is own else group for group in model.groups)
        model = replace(model, groups=groups, **{quantity: csr_array(getattr(model, quantity) + share)})
    return model


def _enriched(
    model: LinearModel, factors: SuperLU, shapes: FloatArray, omega: FloatArray, followed: int, causes: Sequence[Dof]
) -> FloatArray:
    """Return the basis (free, coordinate): ``shapes`` (free, mode) first, then static shapes."""
    first = shapes[:, :followed]
    extra = [_beyond(model, shapes, _static(factors, _forces_at(model.dofs, causes)))]
    for group in model.groups:
        for share, size in ((group.stiffness, np.ones(followed)), (group.mass, omega[:followed] ** 2)):
            if share.nnz:
                forces = _strongest((share @ first) * (size / omega[:followed] ** 2))
                extra.append(_beyond(model, shapes, _static(factors, forces)))
    return np.column_stack([shapes, _orthogonal(model.stiffness, np.column_stack(extra))])


def _forces_at(dofs: DofMap, places: Sequence[Dof]) -> FloatArray:
    """Return a unit force at each of the ``places``, (free, place)."""
    forces = np.zeros((len(dofs.free_rows), len(places)))
    for number, place in enumerate(places):
        forces[:, number] = dofs.gathered(dofs.pull([(*place, 1.0)]))
    return forces


def _static(factors: SuperLU, forces: FloatArray) -> FloatArray:
    """Return the displacements under ``forces`` (free, load), a few loads at a time."""
    parts = range(0, forces.shape[1], COORDINATES.loads_at_once)
    solved = [factors.solve(np.ascontiguousarray(forces[:, k : k + COORDINATES.loads_at_once])) for k in parts]
    return np.column_stack(solved) if solved else forces


def _strongest(forces: FloatArray) -> FloatArray:
    """Return the combinations of ``forces`` (free, load) that are largest."""
    squares, turns = np.linalg.eigh(forces.T @ forces)
    kept = squares > COORDINATES.min_force_share**2 * squares[-1]
    kept[: -COORDINATES.most_shapes_a_share] = False
    return np.asarray(forces @ turns[:, kept])


def _beyond(model: LinearModel, shapes: FloatArray, moved: FloatArray) -> FloatArray:
    """Return the part of displacements (free, load) that lies in none of the modes, (free, load)."""
    return np.asarray(moved - shapes @ (shapes.T @ (model.mass @ moved)))


def _orthogonal(stiffness: csr_array, shapes: FloatArray) -> FloatArray:
    """Return shapes that span the same, Psi^T K Psi = 1, less those that others nearly make up."""
    energy = np.einsum("di,di->i", shapes, stiffness @ shapes)
    felt = energy > 0
    shapes = shapes[:, felt] / np.sqrt(energy[felt])
    squares, turns = np.linalg.eigh(shapes.T @ (stiffness @ shapes))
    kept = squares > COORDINATES.min_independent_share * squares[-1]
    return np.asarray(shapes @ (turns[:, kept] / np.sqrt(squares[kept])))


def _projected(model: LinearModel, basis: FloatArray) -> LinearModel:
    def part(matrix: csr_array) -> csr_array:
        inside = basis.T @ (matrix @ basis)
        return csr_array(0.5 * (inside + inside.T))

    size = basis.shape[1]
    dofs = DofMap(np.arange(1, size + 1), np.full(size, ""), np.ones(size, dtype=bool))
    groups = tuple(MatrixGroup(group.name, part(group.mass), part(group.stiffness)) for group in model.groups)
    matrices = part(model.mass), part(model.damping), part(model.stiffness)
    return LinearModel(*matrices, dofs, np.zeros((size, 2)), model.modal_ratios, model.replaced_ratios, groups)


def _row_of(dofs: DofMap, row: int, basis: FloatArray) -> FloatArray:
    """Return the motion of one degree of freedom with each coordinate of a ``basis`` (free, coordinate)."""
    unit = np.zeros(len(dofs))
    unit[row] = 1.0
    own = dofs.gathered(unit)
    felt = np.flatnonzero(own)
    return np.asarray(own[felt] @ basis[felt])


def _nodes_to_search(dofs: DofMap, shapes: FloatArray) -> dict[int, tuple[int, ...]]:
    """Return the nodes at which causes are sought, each with those that move nearly as it does.

    Of many nodes those that differ most in the modes: each next one is farthest from all before it (Gonzalez, 1985).
    """
    moving = dofs.moves & np.isin(dofs.direction, TRANSLATIONS)
    nodes = np.unique(dofs.node[moving])
    motion = np.zeros((len(nodes), len(TRANSLATIONS), shapes.shape[1]))
    for axis, name in enumerate(TRANSLATIONS):
        rows = np.flatnonzero(moving & (dofs.direction == name))
        motion[np.searchsorted(nodes, dofs.node[rows]), axis] = shapes[rows]
    flat = motion.reshape(len(nodes), -1)
    flat = flat[:, flat.any(axis=0)]
    size = np.abs(flat).max(initial=0.0)
    felt = np.flatnonzero(np.abs(flat).max(axis=1, initial=0.0) > COORDINATES.min_motion_share * size)
    nodes, flat = nodes[felt], flat[felt] / np.maximum(np.abs(flat).max(axis=0, initial=0.0), np.finfo(float).tiny)
    if len(nodes) <= COORDINATES.most_nodes:
        return {int(node): () for node in nodes}
    chosen = [int(np.argmax(np.linalg.norm(flat, axis=1)))]
    apart = np.linalg.norm(flat - flat[chosen[0]], axis=1)
    nearest = np.zeros(len(nodes), dtype=np.int64)
    while len(chosen) < COORDINATES.most_nodes:
        chosen.append(int(np.argmax(apart)))
        own = np.linalg.norm(flat - flat[chosen[-1]], axis=1)
        nearest[own < apart] = len(chosen) - 1
        apart = np.minimum(apart, own)
    return {int(nodes[row]): _others(nodes[nearest == number], int(nodes[row])) for number, row in enumerate(chosen)}


def _others(nodes: IntArray, own: int) -> tuple[int, ...]:
    return tuple(int(node) for node in nodes if node != own)


def _masses(model: LinearModel, shapes: FloatArray, wanted: Sequence[int]) -> tuple[dict[int, float], float]:
    """Return what nodes weigh, kg, in the direction in which each moves most, and what all weigh."""
    dofs, diagonal = model.dofs, np.zeros(len(model.dofs))
    diagonal[dofs.free] = model.mass.diagonal()
    translations = np.isin(dofs.direction, TRANSLATIONS)
    moved = np.where(translations, np.abs(shapes).max(axis=1), -1.0)
    order = np.lexsort((moved, dofs.node))  # the last row of each node is the one that moves most
    last = np.append(np.diff(dofs.node[order]) > 0, True)
    rows = order[last]
    whole = float(diagonal[rows][translations[rows]].sum())
    each = dict(zip(dofs.node[rows].tolist(), diagonal[rows].tolist(), strict=True))
    return {node: float(each.get(node, 0.0)) for node in wanted}, whole
