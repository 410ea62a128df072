"""Exudyn's view of a structure: the matrices of one item alone, and the whole as one system."""

from collections.abc import Iterator
from dataclasses import dataclass

import exudyn as exu
import numpy as np
from exudyn.itemInterface import ObjectConnectorCoordinate

from fe_models.dofs import FloatArray
from fe_models.effects import ConnectorEffect
from fe_models.exudyn_items import (
    Item,
    Options,
    System,
    add_item,
    add_node,
    coordinate_marker,
    ground_marker,
    new_system,
)
from fe_models.mesh import Mesh
from fe_models.structure import Beam, Dashpot, Direction, PointMass, Structure


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
    """Yield all that has mass, stiffness or damping: the item, its mesh nodes (from 1), and the vector along it (m)."""
    vectors = [element_vector(structure, number) for number in range(1, len(structure.elements) + 1)]
    for part in mesh.elements:
        yield structure.elements[part.parent - 1], part.nodes, vectors[part.parent - 1]
    for mass in structure.point_masses:
        yield mass, (mass.node,), np.zeros(2)
    connectors: tuple[Dashpot | ConnectorEffect, ...] = (*structure.dashpots, *structure.effects)
    for connector in connectors:
        yield connector, connector.nodes, np.zeros(2)


def whole_system(structure: Structure, mesh: Mesh, options: Options) -> System:
    """Return all of a structure, supports included, as one system; its coordinates have the order of ``mesh.dofs``."""
    system = new_system(structure.directions)
    nodes = [add_node(system, position) for position in mesh.coordinates]
    for item, item_nodes, vector in items_of(structure, mesh):
        add_item(system, item, [nodes[node - 1] for node in item_nodes], vector, options)
    ground = ground_marker(system)
    for row in np.flatnonzero(~mesh.dofs.free):
        node, direction = nodes[mesh.dofs.node[row] - 1], mesh.dofs.direction[row]
        marker = coordinate_marker(system, node, structure.directions.index(direction))
        system.mbs.AddObject(ObjectConnectorCoordinate(markerNumbers=[ground, marker]))
    return system
