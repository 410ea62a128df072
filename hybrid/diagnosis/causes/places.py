"""Where forces can act on a structure, and how much of one is felt there."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from fe_models.arrays import FloatArray
from fe_models.structure import Direction, Spring, Structure
from hybrid.diagnosis.nominal.plant import Plant

UNMOVED = 1e-4  # of the largest entry of the mode shapes, or motion: a place that moves less feels no force
NEAR = 0.5  # of the shortest element there: nearer nodes that no element joins are of two parts side by side
ALIKE = 0.01  # of its motion in the modes: how far apart two places may be to count as one
DAMPED = 0.2  # of the dashpot whose force is as large as a spring's at the usual rate


Nodes = tuple[int] | tuple[int, int]  # against the ground, or against one another
Elongation = tuple[dict[str, Any], Nodes, Direction, FloatArray]  # location, nodes, direction, coefficients (dof,)


@dataclass(frozen=True)
class Motion:
    """Displacement and velocity (..., dof) that the nominal model needs to follow the recordings."""

    displacement: FloatArray
    velocity: FloatArray

    @classmethod
    def of_states(cls, states: FloatArray, plant: Plant) -> "Motion":
        """Return the motion of modal states (..., state) of a plant: displacements, then velocities."""
        n = plant.size
        shapes = plant.basis[:, :n]
        return cls(states[..., :n] @ shapes.T, states[..., n : 2 * n] @ shapes.T)


@dataclass(frozen=True)
class Place:
    """A degree of freedom against the ground, or the difference of two.

    ``location``: in a report's words; ``pull`` (dof,): its elongation's coefficients; ``stiffness`` (N/m) and damping
    ``coefficient`` (N s/m): what is felt there, as a prior is wide; ``twins``: locations that move with it.
    """

    location: dict[str, Any]
    nodes: Nodes
    direction: Direction
    pull: FloatArray
    stiffness: float
    coefficient: float
    twins: tuple[dict[str, Any], ...] = ()


def places_of(plant: Plant, motion: Motion) -> list[Place]:
    """Return where forces can act: each free translation, and between two nodes that springs join, or nothing does
    though they are near.

    Of places that move alike in all modes (the nodes of a stiff deck along it) the first stands for all.
    """
    found: list[Place] = []
    moves: list[FloatArray] = []
    shapes = plant.modes[1]
    for location, nodes, direction, pull in _elongations(plant):
        move = pull @ shapes
        size = float(np.linalg.norm(move))
        if size < UNMOVED * np.abs(shapes).max():
            continue
        alike = [i for i, other in enumerate(moves) if np.linalg.norm(move - other) < ALIKE * size]
        if alike and not plant.is_chain:
            first = found[alike[0]]
            found[alike[0]] = replace(first, twins=(*first.twins, location))
            continue
        found.append(Place(location, nodes, direction, pull, *_felt(plant, pull, motion)))
        moves.append(move)
    return found


def _elongations(plant: Plant) -> list[Elongation]:
    """Return every elongation that a force can act along."""
    structure, dofs = plant.structure, plant.dofs
    units = np.eye(len(dofs))
    found: list[Elongation] = []
    for direction in structure.directions:
        if direction == "rz":
            continue
        rows = [row for row in dofs.free_rows if dofs.direction[row] == direction]
        nodes = {int(dofs.node[row]): row for row in rows if dofs.node[row] <= len(structure.nodes)}
        found += [({"node": n, "direction": direction}, (n,), direction, units[row]) for n, row in nodes.items()]
        for first, last in _pairs(structure, direction):
            if first in nodes and last in nodes:
                where = {"nodes": [first, last], "direction": direction}
                found.append((where, (first, last), direction, units[nodes[last]] - units[nodes[first]]))
    return found


def _pairs(structure: Structure, direction: Direction) -> list[tuple[int, int]]:
    """Return every two nodes that springs join, and those of two parts so near that they may rub, knock or be tied."""
    springs = [e.nodes for e in structure.elements if isinstance(e, Spring) and e.direction == direction]
    joined = [(min(pair), max(pair)) for pair in springs if len(pair) == 2]
    lines = [e for e in structure.elements if not isinstance(e, Spring)]
    shortest = np.zeros(len(structure.nodes))  # m, of the elements at each node
    for element in sorted(lines, key=structure.length, reverse=True):
        shortest[[node - 1 for node in element.nodes]] = structure.length(element)
    points = np.array(structure.nodes)
    tree, ends = cKDTree(points), {frozenset(element.nodes) for element in lines}
    for i, j in sorted(tree.query_pairs(NEAR * float(shortest.max()))) if lines else ():
        near = np.linalg.norm(points[i] - points[j]) <= NEAR * min(shortest[i], shortest[j])
        if near and {i + 1, j + 1} not in ends:
            joined.append((i + 1, j + 1))
    return list(dict.fromkeys(joined))


def _felt(plant: Plant, pull: FloatArray, motion: Motion) -> tuple[float, float]:
    """Return stiffness and damping coefficient: a chain's mean spring, elsewhere what the structure resists there."""
    free = plant.dofs.free
    if plant.is_chain:
        mass, stiffness = (float(np.mean(matrix.diagonal()[free])) for matrix in (plant.mass, plant.stiffness))
        return stiffness / 2, DAMPED * float(np.sqrt(mass * stiffness / 2))
    stiffness = 1 / float(pull @ plant.static(pull[:, None])[:, 0])
    moved = float(np.std(motion.displacement @ pull))
    omega = float(np.std(motion.velocity @ pull)) / moved if moved > 0 else float(plant.modes[0][0])
    return stiffness, DAMPED * stiffness / omega
