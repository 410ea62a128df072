"""Where forces can act on a structure, and how much of one is felt there."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.structure import ROTATIONS, Direction, Spring, Structure

MIN_MOTION_SHARE = 1e-4  # of the largest entry of the mode shapes, or motion: a place that moves less feels no force
MAX_GAP_SHARE = 0.5  # of the shortest element there: nearer nodes that no element joins are of two parts side by side
MAX_TWIN_DIFFERENCE = 0.01  # of its motion in the modes: how far apart two places may be to count as one
# of the largest elongation: where a search for a gap, or slackness, starts
STARTING_SHARES = (0.1, 0.25, 0.45, 0.65, 0.85)
LARGEST_QUANTILE = 0.999  # quantile of an elongation that counts as its largest
MIN_ELONGATION_SHARE = 1e-3  # of the rms elongation: what a gap, or the largest elongation of one side, is at least
DASHPOT_SHARE = 0.2  # of the dashpot whose force is as large as a spring's at the usual rate


Nodes = tuple[int] | tuple[int, int]  # against the ground, or against one another
Elongation = tuple[dict[str, Any], Nodes, Direction, FloatArray]  # location, nodes, direction, coefficients (dof,)


class ModelForPlaces(Protocol):
    """A structure as places ask for it.

    ``is_chain``: whether all is springs and masses in one direction; ``mass`` and ``stiffness``: sparse (dof, dof), as
    if no support held it; ``modes``: natural frequencies (rad/s) and mass-normalised shapes (dof, mode).
    """

    @property
    def structure(self) -> Structure: ...  # noqa: D102
    @property
    def is_chain(self) -> bool: ...  # noqa: D102
    @property
    def dofs(self) -> DofMap: ...  # noqa: D102
    @property
    def mass(self) -> csr_array: ...  # noqa: D102
    @property
    def stiffness(self) -> csr_array: ...  # noqa: D102
    @property
    def modes(self) -> tuple[FloatArray, FloatArray]: ...  # noqa: D102

    def static(self, forces: FloatArray) -> FloatArray:
        """Return the displacements (dof, load) under ``forces`` (dof, load), supports holding."""


@dataclass(frozen=True)
class Motion:
    """Displacement and velocity (..., dof) that the nominal model needs to follow the recordings."""

    displacement: FloatArray
    velocity: FloatArray

    @classmethod
    def of_states(cls, states: FloatArray, shapes: FloatArray) -> "Motion":
        """Return the motion of states (..., state), coordinates of ``shapes`` (dof, coordinate), then their rates."""
        n = shapes.shape[1]
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

    @property
    def at(self) -> tuple[Nodes, Direction]:
        """Where it is, as a connector has it."""
        return self.nodes, self.direction


@dataclass(frozen=True)
class MovingPlace:
    """A ``place`` with its ``elongation`` u (m) and ``rate`` v (m/s), both (...,)."""

    place: Place
    elongation: FloatArray
    rate: FloatArray

    @classmethod
    def of(cls, place: Place, motion: Motion) -> "MovingPlace":
        """Return a place in motion."""
        return cls(place, motion.displacement @ place.pull, motion.velocity @ place.pull)

    @cached_property
    def size(self) -> float:
        """The rms elongation, m."""
        return float(np.std(self.elongation))

    @cached_property
    def speed(self) -> float:
        """The rms rate, m/s."""
        return float(np.std(self.rate))


def places_of(nominal: ModelForPlaces, motion: Motion) -> list[Place]:
    """Return where forces can act: each free translation, and between two nodes that springs join, or nothing does
    though they are near.

    Of places that move alike in all modes (the nodes of a stiff deck along it) the first stands for all.
    """
    return places_among(nominal, motion, _elongations(nominal))


def places_among(nominal: ModelForPlaces, motion: Motion, elongations: Sequence[Elongation]) -> list[Place]:
    """Return those of the ``elongations`` that move, the first of any that move alike standing for the others."""
    found: list[Place] = []
    moves: list[FloatArray] = []
    shapes = nominal.modes[1]
    for location, nodes, direction, pull in elongations:
        move = pull @ shapes
        size = float(np.linalg.norm(move))
        if size < MIN_MOTION_SHARE * np.abs(shapes).max():
            continue
        alike = [i for i, other in enumerate(moves) if np.linalg.norm(move - other) < MAX_TWIN_DIFFERENCE * size]
        if alike and not nominal.is_chain:
            first = found[alike[0]]
            found[alike[0]] = replace(first, twins=(*first.twins, location))
            continue
        found.append(Place(location, nodes, direction, pull, *_felt(nominal, pull, motion)))
        moves.append(move)
    return found


def _elongations(nominal: ModelForPlaces) -> list[Elongation]:
    """Return every elongation that a force can act along."""
    structure, dofs = nominal.structure, nominal.dofs
    units = np.eye(len(dofs))
    found: list[Elongation] = []
    for direction in structure.directions:
        if direction in ROTATIONS:
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
    for i, j in sorted(tree.query_pairs(MAX_GAP_SHARE * float(shortest.max()))) if lines else ():
        near = np.linalg.norm(points[i] - points[j]) <= MAX_GAP_SHARE * min(shortest[i], shortest[j])
        if near and {i + 1, j + 1} not in ends:
            joined.append((i + 1, j + 1))
    return list(dict.fromkeys(joined))


def _felt(nominal: ModelForPlaces, pull: FloatArray, motion: Motion) -> tuple[float, float]:
    """Return stiffness and damping coefficient: a chain's mean spring, elsewhere what the structure resists there."""
    free = nominal.dofs.free
    if nominal.is_chain:
        mass, stiffness = (float(np.mean(matrix.diagonal()[free])) for matrix in (nominal.mass, nominal.stiffness))
        return stiffness / 2, DASHPOT_SHARE * float(np.sqrt(mass * stiffness / 2))
    stiffness = 1 / float(pull @ nominal.static(pull[:, None])[:, 0])
    moved = float(np.std(motion.displacement @ pull))
    omega = float(np.std(motion.velocity @ pull)) / moved if moved > 0 else float(nominal.modes[0][0])
    return stiffness, DASHPOT_SHARE * stiffness / omega
