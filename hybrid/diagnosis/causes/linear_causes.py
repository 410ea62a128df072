"""Causes that change M, C or K, at every place: stiffness, forces at rest, masses, springs, dashpots, soft supports."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import cast

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray, IntArray
from fe_models.assembly import linearise
from fe_models.causes import AddedMass, AxialForce, Cause, DeadLoad, Effect, PointDamper, StiffnessChange, SupportSpring
from fe_models.causes.dead_load import dead_load_share
from fe_models.causes.laws import with_parts
from fe_models.errors import InputError
from fe_models.matrix_changes import matrix_changes
from fe_models.modes import natural_modes
from fe_models.structure import Direction, Element, Spring, Structure
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.causes.equilibrium import is_borne
from hybrid.diagnosis.causes.places import Place
from hybrid.diagnosis.nominal.plant import Plant

HEAVY = 0.05  # of the structure's mass: the prior standard deviation of an added mass
HALF = 0.5  # of a chain's mean mass, of an element's stiffness, of what is felt at a place: the same for others
LIGHTEST = 0.95  # of what a node weighs: as much may be missing there
FIRM = 1e-4  # of a structure's own compliance at a support: as good as rigid
SOFT = 5.0  # of it: the prior standard deviation of a support's own; at ten times as much it is as good as lost
MECHANISM = 1e-9  # of the stiffness at a support: what rounding leaves of a structure's own where nothing else holds it
BUCKLING = 0.3  # of a squared frequency: what the usual axial force takes from it
UNBORNE = 0.1  # how probable an axial force is that nothing takes off where its element ends, to one that is borne:
# possible, for weights and friction are not drawn, but of two that sensors hardly tell apart not the first to think of
ECHOED = 0.1  # likewise a spring to the ground beside one that the structure has: that one would be off instead
YIELDING = 2e-3  # the strain that no metal of a structure bears for long ...
WORKING = 5e-4  # ... and that which structures are designed for, 100 N/mm^2 in steel
HARDLY = 1e-4  # of squared frequencies: a dead load that changes none by more is not felt
LEAST_WEIGHT, MOST_WEIGHT = 0.5, 1.5  # times what is drawn: no less weight than that, and no more, goes unnoticed
ANY = (-np.inf,)

Changes = tuple[csr_array, csr_array, csr_array]


def linear_causes(plant: Plant, places: list[Place]) -> list[Candidate]:
    """Return them all; of an uncertain group of elements the whole may change, too."""
    return [
        *_stiffness_changes(plant),
        *_axial_forces(plant),
        *_dead_load(plant),
        *_added_masses(plant),
        *(_support_spring(plant, place) for place in places if len(place.nodes) == 1),
        *(_point_damper(plant, place) for place in places),
        *_soft_supports(plant),
        *_stiff_pins(plant),
    ]


def _element_groups(plant: Plant) -> list[tuple[int, ...]]:
    """Return each element alone, and those that are uncertain as a whole."""
    groups = [part.elements for part in plant.parts if part.quantity == "stiffness" and len(part.elements) > 1]
    return [(number,) for number in range(1, len(plant.structure.elements) + 1)] + groups


def _unit(plant: Plant, effect: Effect) -> Changes:
    moved = matrix_changes(plant.structure, effect)
    return moved.mass, moved.damping, moved.stiffness


def _stiffness_changes(plant: Plant) -> list[Candidate]:
    return [
        Candidate(
            kind=StiffnessChange.kind,
            location=StiffnessChange(numbers, 1.0).location,
            names=("factor",),
            build=partial(StiffnessChange, numbers),
            neutral=(1.0,),
            width=(HALF,),
            lower=(0.0,),
            changes=_unit(plant, StiffnessChange(numbers, 2.0)),
            part=_part_of(plant, numbers),
        )
        for numbers in _element_groups(plant)
    ]


def _part_of(plant: Plant, numbers: tuple[int, ...]) -> int | None:
    """Return the uncertain stiffness that elements are of: what they lack, they lack of that."""
    for number, part in enumerate(plant.parts):
        if part.quantity == "stiffness" and set(numbers) <= set(part.elements):
            return number
    return None


def _axial_forces(plant: Plant) -> list[Candidate]:
    found = []
    for numbers in _element_groups(plant):
        effect = AxialForce(numbers, 1.0)
        if not effect.faults(plant.structure):
            unit = _unit(plant, effect)
            own = [plant.structure.elements[number - 1] for number in numbers]
            stretch = min(_axial_stiffness(element) for element in own)
            found.append(
                Candidate(
                    kind=AxialForce.kind,
                    location=effect.location,
                    names=("force",),
                    build=partial(AxialForce, numbers),
                    neutral=(0.0,),
                    width=(min(_felt_force(plant, unit[2]), WORKING * stretch),),
                    lower=(-YIELDING * stretch,),
                    upper=(YIELDING * stretch,),
                    changes=unit,
                    weight=_weight(plant.structure, own),
                )
            )
    return found


def _weight(structure: Structure, elements: list[Element]) -> float:
    """Return how probable an axial force in these elements is, to another; several are what the user calls a member."""
    return 1.0 if len(elements) > 1 or is_borne(with_parts(structure), elements[0]) else UNBORNE


def _axial_stiffness(element: Element) -> float:
    """Return E A (N) of a beam or a cable; what has no section bears any force."""
    return np.inf if isinstance(element, Spring) else element.section.axial_stiffness


def _felt_force(plant: Plant, stiffness: csr_array) -> float:
    """Return the axial force (N) that changes the square of some mode's frequency by 30 %: a third of buckling."""
    omega, shapes = plant.modes
    softened = np.abs(np.einsum("di,di->i", shapes, stiffness @ shapes))
    return BUCKLING * float(np.min(omega**2 / np.maximum(softened, 1e-12 * omega**2)))


def _dead_load(plant: Plant) -> list[Candidate]:
    """Return what weight and prestress do to small motions; none where that is not felt, or nothing would stand."""
    effect, structure = DeadLoad(), plant.structure
    if effect.faults(structure) or dead_load_share(structure):
        return []
    omega, _ = plant.modes
    try:
        changes = _unit(plant, effect)
        loaded = natural_modes(linearise(structure.with_effects(effect)), len(omega)).omega
    except InputError:  # no state at rest, or none that stands
        return []
    if np.all(np.abs(loaded**2 - omega**2) < HARDLY * omega**2):  # all modes give way to it, as a roller does
        return []
    return [
        Candidate(
            kind=DeadLoad.kind,
            location=effect.location,
            names=("share",),
            build=DeadLoad,
            neutral=(0.0,),
            width=(1.0,),
            lower=(LEAST_WEIGHT,),
            upper=(MOST_WEIGHT,),
            changes=changes,
        )
    ]


def _added_masses(plant: Plant) -> list[Candidate]:
    dofs, diagonal, nothing = plant.dofs, plant.mass.diagonal(), _zeros(plant)
    shapes = plant.modes[1]
    masses: dict[int, float] = {}
    for node in range(1, len(plant.structure.nodes) + 1):
        rows = _translations_of(plant, node)
        if len(rows):
            row = int(rows[np.argmax(np.abs(shapes[rows]).max(axis=1))])  # the direction in which it moves most
            if dofs.free[row] and diagonal[row] > 0:
                masses[node] = float(diagonal[row])
    usual = HALF * float(np.mean(list(masses.values()))) if plant.is_chain else HEAVY * sum(masses.values())
    return [
        Candidate(
            kind=AddedMass.kind,
            location={"node": node},
            names=("mass",),
            build=partial(AddedMass, node),
            neutral=(0.0,),
            width=(usual,),
            lower=(-LIGHTEST * mass,),
            changes=(_diagonal(plant, _translations_of(plant, node)), nothing, nothing),
        )
        for node, mass in masses.items()
    ]


def _translations_of(plant: Plant, node: int) -> IntArray:
    return np.flatnonzero((plant.dofs.node == node) & (plant.dofs.direction != "rz"))


def _support_spring(plant: Plant, place: Place) -> Candidate:
    spring, own = _outer(place.pull), (*place.nodes, place.direction)
    springs = [e for e in plant.structure.elements if isinstance(e, Spring)]
    found = _at(
        place,
        SupportSpring.kind,
        "stiffness",
        partial(SupportSpring, place.nodes[0], place.direction),
        HALF * place.stiffness,
        (_zeros(plant), csr_array(plant.structure.damping.stiffness_factor * spring), spring),
    )
    return replace(found, weight=ECHOED) if own in [(*e.nodes, e.direction) for e in springs] else found


def _point_damper(plant: Plant, place: Place) -> Candidate:
    build = partial(PointDamper, place.nodes, place.direction)
    changes = (_zeros(plant), _outer(place.pull), _zeros(plant))
    return _at(place, PointDamper.kind, "coefficient", build, place.coefficient, changes)


def _at(place: Place, kind: str, name: str, build: Callable[..., Cause], width: float, changes: Changes) -> Candidate:
    return Candidate(
        kind=kind,
        location=place.location,
        names=(name,),
        build=build,
        neutral=(0.0,),
        width=(width,),
        lower=ANY,
        changes=changes,
        twins=place.twins,
    )


def _soft_supports(plant: Plant) -> list[Candidate]:
    """Return the supports that may be too soft, each by its compliance: 0 as drawn."""
    found = []
    leaned_on = plant.stiffness.diagonal() > 0  # a cable's end does not lean on what holds it from turning
    for row in np.flatnonzero(~plant.dofs.free & leaned_on):
        node, direction = int(plant.dofs.node[row]), cast(Direction, str(plant.dofs.direction[row]))
        soft = _softness(plant, int(row))
        here = _diagonal(plant, np.array([row]))
        damped = csr_array(plant.structure.damping.stiffness_factor * here)  # as all that is stiff
        found.append(
            Candidate(
                kind=SupportSpring.kind,
                location={"node": node, "direction": direction},
                names=("stiffness",),
                build=_by_compliance(node, direction),
                neutral=(0.0,),
                width=(SOFT * soft,),
                lower=(FIRM * soft,),
                starts=((10 * FIRM * soft,),),
                changes=(_zeros(plant), damped, here),
                released=int(row),
                brings=1,
            )
        )
    return found


def _stiff_pins(plant: Plant) -> list[Candidate]:
    """Return the supports that may resist rotation, though they are drawn to turn freely: base plates, rusty pins."""
    dofs, supported = plant.dofs, [support.node for support in plant.structure.supports]
    turning = dofs.free & (dofs.direction == "rz") & np.isin(dofs.node, supported)
    springs = [e for e in plant.structure.effects if isinstance(e, SupportSpring)]
    found = []
    for row in np.flatnonzero(turning & (plant.stiffness.diagonal() > 0)):
        node, pull = int(dofs.node[row]), np.zeros(len(dofs))
        pull[row] = 1.0
        stiffness = 1 / float(plant.static(pull[:, None])[row, 0])
        place = Place({"node": node, "direction": "rz"}, (node,), "rz", pull, stiffness, coefficient=0.0)
        own = sum(e.stiffness for e in springs if (e.node, e.direction) == (node, "rz"))
        found.append(replace(_support_spring(plant, place), lower=(-own,)))  # a pin turns freely, or resists as drawn
    return found


def _softness(plant: Plant, row: int) -> float:
    """Return the compliance (m/N, rad/(N m)) of a structure where a support gives, by which to size the support's own.

    What stands on this support alone has none, as a mast: then that at which it rocks as slowly as it sways.
    """
    shape = plant.released(row)
    stiffness = float(shape @ (plant.stiffness @ shape))
    if stiffness < MECHANISM * float(plant.stiffness[row, row]):
        stiffness = float(plant.modes[0][0] ** 2 * (shape @ (plant.mass @ shape)))
    return 1 / stiffness


def _by_compliance(node: int, direction: Direction) -> Callable[..., Cause]:
    return lambda compliance: SupportSpring(node, direction, 1 / compliance)


def _outer(pull: FloatArray) -> csr_array:
    """Return b b^T of a place's coefficients, sparse."""
    column = csr_array(pull[:, None])
    return csr_array(column @ column.T)


def _diagonal(plant: Plant, rows: IntArray) -> csr_array:
    return csr_array((np.ones(len(rows)), (rows, rows)), shape=plant.mass.shape)


def _zeros(plant: Plant) -> csr_array:
    return csr_array(plant.mass.shape)
