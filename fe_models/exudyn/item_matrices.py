"""Exudyn's view of a structure: the matrices of one item alone, and the whole as one system."""

from collections.abc import Iterator
from dataclasses import dataclass

import exudyn as exu
import numpy as np
from exudyn.itemInterface import ObjectConnectorCoordinate

from fe_models.arrays import FloatArray
from fe_models.causes import ForceLaw, LawWithMemory, MemorylessLaw
from fe_models.causes.axial_force import GeometricStiffness, axial_forces
from fe_models.causes.force_law import SlowPull
from fe_models.causes.laws import with_parts
from fe_models.causes.slack_cable import SlackLaw
from fe_models.exudyn.items import (
    ExudynSystem,
    Item,
    Options,
    add_chord_law,
    add_force_law,
    add_item,
    add_law_with_memory,
    add_node,
    add_spread_law,
    coordinate_marker,
    ground_marker,
    new_system,
)
from fe_models.mesh import Mesh
from fe_models.structure import Beam, Cable, Direction, PointMass, Structure


@dataclass(frozen=True)
class ElementMatrices:
    """``mass``, ``damping`` and ``stiffness`` of one item, each (n, n) over its nodes' dofs, node by node."""

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray


def element_matrices(
    directions: tuple[Direction, ...],
    item: Item,
    vector: FloatArray,
    options: Options,
    displacement: FloatArray | None = None,
) -> ElementMatrices:
    """Return the matrices of one item alone, linearised at rest at ``displacement`` (n,), by default zero.

    ``vector`` (2,) leads from its first node to its last; an item with one node ignores it. A cable is linearised as
    taut: where it is slack its stiffness is zero, which the caller knows best.
    """
    system = new_system(directions)
    count = 1 if isinstance(item, PointMass) else len(item.nodes)
    nodes = [add_node(system, position) for position in (np.zeros(2), vector)[:count]]
    add_item(system, item, nodes, vector, options)
    system.mbs.Assemble()
    if displacement is not None:
        system.mbs.systemData.SetODE2Coordinates(displacement.tolist(), exu.ConfigurationType.Initial)
    mass, stiffness, damping = system.mbs.ComputeLinearizedSystem()
    return ElementMatrices(mass, damping, stiffness)


def element_vector(structure: Structure, number: int) -> FloatArray:
    """Return the vector (2,) along each finite element of the structure's element ``number`` (from 1), in m.

    Taken from the whole element, so that all its parts have equal bits and are linearised once.
    """
    element = structure.elements[number - 1]
    start, end = (np.array(structure.nodes[node - 1]) for node in (element.nodes[0], element.nodes[-1]))
    vector: FloatArray = (end - start) / (structure.divisions if isinstance(element, Beam) else 1)
    return vector


def items_of(structure: Structure, mesh: Mesh) -> Iterator[tuple[Item, tuple[int, ...], FloatArray]]:
    """Yield all that has mass, stiffness or damping: the item, its mesh nodes (from 1), and the vector along it (m).

    Linear effects are in it, as the parts they stand for; the force laws of the others are not.
    """
    whole, axial = with_parts(structure), axial_forces(structure)
    vectors = [element_vector(structure, number) for number in range(1, len(structure.elements) + 1)]
    for part in mesh.elements:
        element, vector = whole.elements[part.parent - 1], vectors[part.parent - 1]
        yield element, part.nodes, vector
        if part.parent in axial:
            yield GeometricStiffness(part.nodes, axial[part.parent], isinstance(element, Beam)), part.nodes, vector
    for spring in whole.elements[len(structure.elements) :]:
        yield spring, spring.nodes, np.zeros(2)
    for mass in whole.point_masses:
        yield mass, (mass.node,), np.zeros(2)
    for dashpot in whole.dashpots:
        yield dashpot, dashpot.nodes, np.zeros(2)


def whole_system(
    structure: Structure,
    mesh: Mesh,
    options: Options,
    laws: tuple[ForceLaw, ...] = (),
    reference: FloatArray | None = None,
) -> ExudynSystem:
    """Return all of a structure, supports included, as one system; its coordinates have the order of ``mesh.dofs``.

    The force ``laws`` act on elongations from the displacement ``reference`` (dof,), by default the drawn geometry.
    """
    system = new_system(structure.directions)
    nodes = [add_node(system, position) for position in mesh.coordinates]
    for item, item_nodes, vector in items_of(structure, mesh):
        add_item(system, item, [nodes[node - 1] for node in item_nodes], vector, options)
    for law in laws:
        _add_law(system, mesh, law, nodes, np.zeros(len(mesh.dofs)) if reference is None else reference)
    ground = ground_marker(system)
    for row in np.flatnonzero(~mesh.dofs.free):
        node, direction = nodes[mesh.dofs.node[row] - 1], mesh.dofs.direction[row]
        marker = coordinate_marker(system, node, structure.directions.index(direction))
        system.mbs.AddObject(ObjectConnectorCoordinate(markerNumbers=[ground, marker]))
    return system


def _add_law(system: ExudynSystem, mesh: Mesh, law: ForceLaw, nodes: list[int], reference: FloatArray) -> None:
    if isinstance(law, SlackLaw) and isinstance(law.element, Cable):
        first, last = law.element.nodes
        moved = [reference[[mesh.dofs.row(node, axis) for axis in "xy"]] for node in (first, last)]
        length = float(np.hypot(*(np.array(law.vector) + moved[1] - moved[0])))
        add_chord_law(system, law, [nodes[first - 1], nodes[last - 1]], length)
        return
    elongation = float(sum(c * reference[mesh.dofs.row(node, direction)] for node, direction, c in law.pulls))
    if isinstance(law, LawWithMemory | SlowPull):
        own, per_node = sorted({node for node, _, _ in law.pulls}), len(system.directions)
        rows = np.concatenate([per_node * (node - 1) + np.arange(per_node) for node in own])
        pull, there = mesh.dofs.pull(law.pulls)[rows], [nodes[node - 1] for node in own]
        if isinstance(law, LawWithMemory):
            add_law_with_memory(system, law, there, pull, rows)
        else:
            add_spread_law(system, law, there, pull, elongation)
    elif isinstance(law, MemorylessLaw):
        markers = [coordinate_marker(system, nodes[n - 1], system.directions.index(d)) for n, d, _ in law.pulls]
        add_force_law(system, law, markers, elongation)
