"""The items of a structure in Exudyn: nodes, beams, cables, springs, masses, dashpots, force laws.

Only this package imports exudyn. The same functions add an item to the small system that is linearised and to the
whole one that is simulated (`item_matrices`), so that each item is defined once.

Beams are geometrically exact (Simo and Vu-Quoc), linear in shape, integrated at their middle. With the shear stiffness
12 E I / L^2 their linearised stiffness is exactly Euler-Bernoulli's; they stay valid for large displacements, with an
error of order 2 in the mesh: for P-delta in a frame drawn with one beam a column, refine by 4 (0.1 % of f1). Their
consistent mass, and gravity on it, keep the orientation of the drawn geometry: exact for small rotations.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from math import hypot
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.advancedUtilities import CreateSymbolicUserFunction
from exudyn.itemInterface import (
    MarkerNodeCoordinate,
    MarkerNodePosition,
    NodeGenericODE1,
    NodeGenericODE2,
    NodePoint2D,
    NodePointGround,
    NodeRigidBody2D,
    ObjectBeamGeometricallyExact2D,
    ObjectConnectorCoordinateSpringDamper,
    ObjectConnectorSpringDamper,
    ObjectGenericODE1,
    ObjectGenericODE2,
)

from fe_models.arrays import FloatArray, IntArray
from fe_models.cables import cable_free_length
from fe_models.causes import ConnectorEffect, LawWithMemory, MemorylessLaw
from fe_models.causes.axial_force import GeometricStiffness, geometric_stiffness
from fe_models.structure import (
    PLANE_FRAME,
    Beam,
    Cable,
    Damping,
    Dashpot,
    Direction,
    Element,
    PointMass,
    Spring,
)

Index = Any
"""Exudyn's number of a node or marker."""
Item = Element | PointMass | Dashpot | GeometricStiffness | ConnectorEffect


@dataclass(frozen=True)
class ExudynSystem:
    """A quiet Exudyn system under construction; ``functions`` keeps alive what Exudyn refers to only by address;
    ``memories``: the nodes of laws with memory, in the order of the system's ODE1 coordinates.
    """

    directions: tuple[Direction, ...]
    container: Any
    mbs: Any
    functions: list[object] = field(default_factory=list)
    memories: list[Index] = field(default_factory=list)


@dataclass(frozen=True)
class Options:
    """How items are built: Rayleigh's factors, and for cables whether prestress and slackness are modelled."""

    damping: Damping = field(default_factory=Damping)
    prestress: bool = True
    slack: bool = True


def new_system(directions: tuple[Direction, ...]) -> ExudynSystem:
    """Return an empty system that prints nothing."""
    exu.config.printToConsole = False
    exu.config.suppressWarnings = True
    container = exu.SystemContainer()
    return ExudynSystem(directions, container, container.AddSystem())


def add_node(system: ExudynSystem, position: FloatArray) -> Index:
    """Add a node at ``position`` (2,) with the degrees of freedom of the structure, in their order."""
    x, y = (float(value) for value in position)
    if system.directions == PLANE_FRAME:
        node = NodeRigidBody2D(referenceCoordinates=[x, y, 0.0])
    elif system.directions == ("x", "y"):
        node = NodePoint2D(referenceCoordinates=[x, y])
    else:
        zeros = [0.0] * len(system.directions)
        node = NodeGenericODE2(
            referenceCoordinates=zeros,
            initialCoordinates=zeros,
            initialCoordinates_t=zeros,
            numberOfODE2Coordinates=len(zeros),
        )
    return system.mbs.AddNode(node)


def add_item(system: ExudynSystem, item: Item, nodes: list[Index], vector: FloatArray, options: Options) -> None:
    """Add ``item`` at Exudyn's ``nodes``; ``vector`` (2,) leads from its first node to its last (m)."""
    match item:
        case Beam():
            _add_beam(system, item, nodes, vector, options.damping)
        case Cable():
            _add_cable(system, item, nodes, vector, options)
        case Spring():
            damping = options.damping.stiffness_factor * item.stiffness
            _add_between(system, _markers(system, nodes, item.direction), stiffness=item.stiffness, damping=damping)
        case Dashpot():
            _add_between(system, _markers(system, nodes, item.direction), damping=item.coefficient)
        case PointMass():
            mass = np.diag([0.0 if direction == "rz" else item.mass for direction in system.directions])
            _add_mass(system, nodes, mass, options.damping)
        case GeometricStiffness():
            _add_stiffness(system, nodes, geometric_stiffness(item, system.directions, vector))
        case ConnectorEffect():
            add_force_law(system, item, _markers(system, nodes, item.direction))


def _add_beam(system: ExudynSystem, beam: Beam, nodes: list[Index], vector: FloatArray, damping: Damping) -> None:
    length, section = hypot(*vector), beam.section
    stiffness = {
        "Axial": section.axial_stiffness,
        "Bending": section.bending_stiffness,
        "Shear": 12 * section.bending_stiffness / length**2,  # makes one-point integration Euler-Bernoulli
    }
    system.mbs.AddObject(
        ObjectBeamGeometricallyExact2D(
            nodeNumbers=nodes,
            physicsLength=length,
            physicsMassPerLength=0.0,
            physicsCrossSectionInertia=0.0,
            **{f"physics{kind}Stiffness": value for kind, value in stiffness.items()},
            **{f"physics{kind}Damping": damping.stiffness_factor * value for kind, value in stiffness.items()},
        )
    )
    _add_mass(system, nodes, beam_mass(section.mass_per_length, vector), damping)


def beam_mass(mass_per_length: float, vector: FloatArray) -> FloatArray:
    """Return the consistent mass (6, 6) of an Euler-Bernoulli beam along ``vector``: dofs x, y, rz of both nodes."""
    L = hypot(*vector)
    axial = np.array([[140.0, 70.0], [70.0, 140.0]])
    bending = np.array(
        [
            [156.0, 22 * L, 54.0, -13 * L],
            [22 * L, 4 * L**2, 13 * L, -3 * L**2],
            [54.0, 13 * L, 156.0, -22 * L],
            [-13 * L, -3 * L**2, -22 * L, 4 * L**2],
        ]
    )
    local = np.zeros((6, 6))
    local[np.ix_([0, 3], [0, 3])] = axial
    local[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = bending
    c, s = vector / L
    turn = np.kron(np.eye(2), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))
    mass: FloatArray = mass_per_length * L / 420 * turn.T @ local @ turn
    return mass


def _add_cable(system: ExudynSystem, cable: Cable, nodes: list[Index], vector: FloatArray, options: Options) -> None:
    """Add a bar of free length L0, so that its tension is E A (l - L0) / L0 at length l, and its consistent mass."""
    free_length = cable_free_length(cable, vector) if options.prestress else hypot(*vector)
    stiffness = cable.section.axial_stiffness / free_length
    slack = {}
    if cable.tension_only and options.slack:
        slack["springForceUserFunction"] = _tension_only(system)
    system.mbs.AddObject(
        ObjectConnectorSpringDamper(
            markerNumbers=[system.mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in nodes],
            referenceLength=free_length,
            stiffness=stiffness,
            damping=options.damping.stiffness_factor * stiffness,
            **slack,
        )
    )
    translations = np.diag([0.0 if direction == "rz" else 1.0 for direction in system.directions])
    share = cable.section.mass_per_length * hypot(*vector) / 6
    mass: FloatArray = share * np.kron(np.array([[2.0, 1.0], [1.0, 2.0]]), translations)
    _add_mass(system, nodes, mass, options.damping)


def _tension_only(system: ExudynSystem) -> object:
    """Return the force of a spring and damper in parallel that act while the spring is stretched."""

    def tension(
        mbs: Any, t: Any, itemNumber: Any, deltaL: Any, deltaL_t: Any, stiffness: Any, damping: Any, force: Any
    ) -> Any:
        symbolic: Any = exu.symbolic  # type: ignore[attr-defined]  # missing in Exudyn's stub file
        return symbolic.IfThenElse(deltaL > 0.0, stiffness * deltaL + damping * deltaL_t, symbolic.Real(0.0))

    return _symbolic(system, tension, "ObjectConnectorSpringDamper")


def add_force_law(system: ExudynSystem, law: MemorylessLaw, markers: list[Index], reference: float = 0.0) -> None:
    """Add the law's own `force` between coordinate markers, as a function that Exudyn evaluates without Python.

    Its elongation is u_last - u_first, or u of the only marker, less ``reference`` (m).
    """

    def force(
        mbs: Any, t: Any, itemNumber: Any, displacement: Any, velocity: Any, stiffness: Any, damping: Any, offset: Any
    ) -> Any:
        return law.force(displacement - reference, velocity, t)

    function = _symbolic(system, force, "ObjectConnectorCoordinateSpringDamper")
    _add_between(system, markers, springForceUserFunction=function)


def add_chord_law(system: ExudynSystem, law: MemorylessLaw, nodes: list[Index], length: float) -> None:
    """Add the law's own `force` along the line between two nodes, on what exceeds the ``length`` (m) of that line."""

    def force(
        mbs: Any, t: Any, itemNumber: Any, deltaL: Any, deltaL_t: Any, stiffness: Any, damping: Any, force: Any
    ) -> Any:
        return law.force(deltaL, deltaL_t, t)

    system.mbs.AddObject(
        ObjectConnectorSpringDamper(
            markerNumbers=[system.mbs.AddMarker(MarkerNodePosition(nodeNumber=node)) for node in nodes],
            referenceLength=length,
            springForceUserFunction=_symbolic(system, force, "ObjectConnectorSpringDamper"),
        )
    )


def add_spread_law(
    system: ExudynSystem, law: MemorylessLaw, nodes: list[Index], pull: FloatArray, reference: float = 0.0
) -> None:
    """Add the law's own `force` on the elongation ``pull`` (n,) times the n coordinates of ``nodes``, less a
    ``reference`` (m).

    Exudyn calls Python for it, which costs about as much as all the rest of a small system.
    """

    def force(mbs: Any, t: float, itemNumber: Any, q: Any, q_t: Any) -> FloatArray:
        return -pull * float(law.force(pull @ np.asarray(q) - reference, pull @ np.asarray(q_t), t))

    nothing = np.zeros((len(pull), len(pull)))
    system.functions.append(force)
    system.mbs.AddObject(ObjectGenericODE2(nodeNumbers=nodes, massMatrix=nothing, forceUserFunction=force))


def add_law_with_memory(
    system: ExudynSystem, law: LawWithMemory, nodes: list[Index], pull: FloatArray, rows: IntArray
) -> None:
    """Add a law whose elongation is ``pull`` (n,) times the n coordinates of ``nodes``, of which ``rows`` (n,) are the
    numbers among all: its z is an ODE1 coordinate, which every integrator takes along.
    """
    data, number = system.mbs.systemData, len(system.memories)
    stiffness = law.largest_slopes[0] * np.outer(pull, pull)

    def rate(mbs: Any, t: float, itemNumber: Any, z: Any) -> list[float]:
        return [float(law.rate(pull @ np.asarray(data.GetODE2Coordinates_t())[rows], z[0]))]

    def force(mbs: Any, t: float, itemNumber: Any, q: Any, q_t: Any) -> FloatArray:
        return -pull * float(law.force_of(data.GetODE1Coordinates()[number]))

    def slope(mbs: Any, t: float, itemNumber: Any, q: Any, q_t: Any, fODE2: Any, fODE2_t: Any) -> FloatArray:
        return -fODE2 * stiffness  # while it does not slide; Exudyn would take differences that do not see z

    system.functions.extend((rate, force, slope))
    node = system.mbs.AddNode(
        NodeGenericODE1(referenceCoordinates=[0.0], initialCoordinates=[0.0], numberOfODE1Coordinates=1)
    )
    system.memories.append(node)
    system.mbs.AddObject(ObjectGenericODE1(nodeNumbers=[node], rhsUserFunction=rate))
    nothing = np.zeros_like(stiffness)
    system.mbs.AddObject(
        ObjectGenericODE2(nodeNumbers=nodes, massMatrix=nothing, forceUserFunction=force, jacobianUserFunction=slope)
    )


def add_drive(system: ExudynSystem, nodes: list[Index], force: Callable[[float], FloatArray]) -> None:
    """Add a ``force`` of time (n,) on the n coordinates of ``nodes``, in their order."""
    size = len(force(0.0))
    of_time = lru_cache(maxsize=8)(force)  # a step asks for each of its times twice or more

    def pushed(mbs: Any, t: float, itemNumber: Any, q: Any, q_t: Any) -> FloatArray:
        return of_time(t)

    def slope(mbs: Any, t: float, itemNumber: Any, q: Any, q_t: Any, fODE2: Any, fODE2_t: Any) -> FloatArray:
        return np.zeros((size, size))  # or Exudyn would take differences of it

    system.functions.extend((pushed, slope))
    system.mbs.AddObject(
        ObjectGenericODE2(
            nodeNumbers=nodes,
            massMatrix=np.zeros((size, size)),
            forceUserFunction=pushed,
            jacobianUserFunction=slope,
        )
    )


def _symbolic(system: ExudynSystem, function: Callable[..., object], item_type: str) -> object:
    symbolic = CreateSymbolicUserFunction(system.mbs, function, "springForceUserFunction", itemTypeName=item_type)
    system.functions.append(symbolic)
    return symbolic


def _add_mass(system: ExudynSystem, nodes: list[Index], mass: FloatArray, damping: Damping) -> None:
    system.mbs.AddObject(
        ObjectGenericODE2(nodeNumbers=nodes, massMatrix=mass, dampingMatrix=damping.mass_factor * mass)
    )


def _add_stiffness(system: ExudynSystem, nodes: list[Index], stiffness: FloatArray) -> None:
    system.mbs.AddObject(
        ObjectGenericODE2(nodeNumbers=nodes, massMatrix=np.zeros_like(stiffness), stiffnessMatrix=stiffness)
    )


def _add_between(system: ExudynSystem, markers: list[Index], **properties: object) -> None:
    """Add a spring, damper or force law on u_last - u_first, or on the coordinate of the only marker."""
    both = markers if len(markers) == 2 else [ground_marker(system), *markers]
    system.mbs.AddObject(ObjectConnectorCoordinateSpringDamper(markerNumbers=both, **properties))


def _markers(system: ExudynSystem, nodes: list[Index], direction: Direction) -> list[Index]:
    return [coordinate_marker(system, node, system.directions.index(direction)) for node in nodes]


def coordinate_marker(system: ExudynSystem, node: Index, coordinate: int) -> Index:
    """Add and return a marker on one coordinate of an Exudyn node."""
    return system.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))


def ground_marker(system: ExudynSystem) -> Index:
    """Add and return a marker on a coordinate that stays zero."""
    ground = system.mbs.AddNode(NodePointGround())
    return system.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
