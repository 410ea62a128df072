"""All causes at all places of a structure: what each changes, its parameters, where a search starts and ends."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, cast

import numpy as np
from scipy.sparse import csr_array

from fe_models.dofs import FloatArray, IntArray
from fe_models.effects import (
    AddedMass,
    AxialForce,
    Cause,
    CoulombFriction,
    CubicSpring,
    Effect,
    GapStop,
    HarmonicForce,
    ModalDamping,
    PointDamper,
    QuadraticDamper,
    SlackCable,
    StiffnessChange,
    SupportSpring,
)
from fe_models.matrix_changes import matrix_changes
from fe_models.recordings import Dataset
from fe_models.sensor_effects import SensorDelay, SensorDrift, SensorGain
from fe_models.structure import Direction
from hybrid.diagnosis.plant import Plant

CREEP = 0.01  # of the rms rate at its place: the rate below which friction is taken as a dashpot
SMALL = 1e-5  # of a prior width: the step at which a response counts as of first order, however long a recording is
UNMOVED = 1e-4  # of the largest entry of the mode shapes: a place that moves less feels no force
ALIKE = 0.01  # of its motion in the modes: how far apart two places may be to count as one
HEAVY = 0.05  # of the structure's mass: the prior standard deviation of an added mass
FIRM = 1e-4  # of a structure's own compliance at a support: as good as rigid
REACHES = (0.1, 0.25, 0.45, 0.65, 0.85)  # of the largest elongation: where a search for a gap starts


@dataclass(frozen=True)
class Candidate:
    """One kind of cause at one place.

    ``build`` makes the cause from its parameters (of arrays, one of arrays). ``names``: their words; ``neutral``:
    values at which it does nothing; ``width``: prior standard deviations about them; ``lower``: bounds; ``starts``:
    values at which a search may begin; with ``scalable`` the first of them is small, and the score test finds its size.
    The cause is felt by what of the following is set: ``changes`` dM, dC, dK, sparse (dof, dof), for each unit of its
    `amount`, ``mode`` (from 0), ``pull`` (dof,) of a force law or of an ``oscillator``, ``sensor`` (position among the
    measured ones), or nothing (the time steps). ``released``: the row that a support holds in the nominal structure;
    the parameter is then the compliance there. ``twins``: other places where it would do the same.
    """

    kind: str
    location: dict[str, Any]
    names: tuple[str, ...]
    build: Callable[..., Cause] = field(compare=False, repr=False)
    neutral: tuple[float, ...]
    width: tuple[float, ...]
    lower: tuple[float, ...]
    starts: tuple[tuple[float, ...], ...] = ()
    scalable: bool = True
    changes: tuple[csr_array, csr_array, csr_array] | None = field(default=None, compare=False, repr=False)
    mode: int | None = None
    pull: FloatArray | None = field(default=None, compare=False, repr=False)
    oscillator: bool = False
    sensor: int | None = None
    released: int | None = None
    twins: tuple[dict[str, Any], ...] = ()

    def amount(self, values: FloatArray) -> FloatArray:
        """Return how many of its ``changes`` a parameter (variant,) stands for."""
        return values - self.neutral[0] if self.released is None else 1 / values

    @property
    def first_starts(self) -> tuple[tuple[float, ...], ...]:
        """The ``starts``; where none are given, a small step away from doing nothing."""
        if self.starts or not self.names:
            return self.starts or ((),)
        return (tuple(a + SMALL * b for a, b in zip(self.neutral, self.width, strict=True)),)

    @property
    def without(self) -> tuple[float, ...]:
        """Values at which it does nothing that can be computed with: a support as good as rigid is not quite."""
        return self.neutral if self.released is None else self.lower

    @property
    def is_law(self) -> bool:
        """Whether it is a force that is not linear in the motion."""
        return self.pull is not None and not self.oscillator

    @property
    def key(self) -> str:
        """Kind and place as one word, the same for the same candidate."""
        return f"{self.kind} {self.location}"


@dataclass(frozen=True)
class Motion:
    """Displacement and velocity (..., dof) that the nominal model needs to follow the recordings."""

    displacement: FloatArray
    velocity: FloatArray


def all_candidates(plant: Plant, dataset: Dataset, motion: Motion, measured: tuple[int, ...]) -> tuple[Candidate, ...]:
    """Return every cause at every place that it can have; ``measured``: columns of the sensors that are fitted."""
    return (
        *_linear(plant, motion),
        *_modes(plant),
        *_laws(plant, motion),
        *_oscillators(plant),
        *_sensors(dataset, motion, measured),
        *_steps(plant),
    )


@dataclass(frozen=True)
class Place:
    """A degree of freedom against the ground, or the difference of two: ``location`` in a report's words, ``nodes``,
    ``direction`` and coefficients ``pull`` (dof,); ``twins``: locations that move with it.
    """

    location: dict[str, Any]
    nodes: tuple[int, ...]
    direction: str
    pull: FloatArray
    twins: tuple[dict[str, Any], ...] = ()


def places(plant: Plant) -> list[Place]:
    """Return where forces can act: each free translation, and, in a chain, each two joined nodes.

    Of places that move alike in all modes (the nodes of a stiff deck along it) the first stands for all.
    """
    found: list[Place] = []
    moves: list[FloatArray] = []
    shapes = plant.modes[1]
    for place in _translations(plant):
        move = place.pull @ shapes
        size = float(np.linalg.norm(move))
        if size < UNMOVED * np.abs(shapes).max():
            continue
        alike = [i for i, other in enumerate(moves) if np.linalg.norm(move - other) < ALIKE * size]
        if alike and not plant.is_chain:
            first = found[alike[0]]
            found[alike[0]] = replace(first, twins=(*first.twins, place.location))
            continue
        found.append(place)
        moves.append(move)
    return found


def _translations(plant: Plant) -> list[Place]:
    structure, dofs = plant.structure, plant.dofs
    found = []
    for row in dofs.free_rows:
        node, direction = int(dofs.node[row]), str(dofs.direction[row])
        if node <= len(structure.nodes) and direction != "rz":
            found.append(Place({"node": node, "direction": direction}, (node,), direction, np.eye(len(dofs))[row]))
    if plant.is_chain:
        direction = structure.directions[0]
        free = {place.nodes[0]: place.pull for place in found}
        pairs = [e.nodes for e in structure.elements if len(e.nodes) == 2 and all(node in free for node in e.nodes)]
        for first, last in dict.fromkeys((min(pair), max(pair)) for pair in pairs):
            where = {"nodes": [first, last], "direction": direction}
            found.append(Place(where, (first, last), direction, free[last] - free[first]))
    return found


@dataclass(frozen=True)
class Scale:
    """What is felt at a place: a ``stiffness`` (N/m) and a damping ``coefficient`` (N s/m) as wide as a prior's."""

    stiffness: float
    coefficient: float


def _scale(plant: Plant, place: Place, motion: Motion) -> Scale:
    """Return the scale at a place: in a chain the mean spring and mass, elsewhere what the structure resists there."""
    free = plant.dofs.free
    if plant.is_chain:
        mass, stiffness = (float(np.mean(matrix.diagonal()[free])) for matrix in (plant.mass, plant.stiffness))
        return Scale(stiffness / 2, 0.2 * float(np.sqrt(mass * stiffness / 2)))
    stiffness = 1 / float(place.pull @ plant.static(place.pull[:, None])[:, 0])
    moved = float(np.std(motion.displacement @ place.pull))
    omega = float(np.std(motion.velocity @ place.pull)) / moved if moved > 0 else float(plant.modes[0][0])
    return Scale(stiffness, 0.2 * stiffness / omega)


def _linear(plant: Plant, motion: Motion) -> list[Candidate]:
    structure, dofs = plant.structure, plant.dofs
    found = []
    infinite = (-np.inf,)
    nothing = csr_array(plant.mass.shape)

    def changes(unit: Effect) -> tuple[csr_array, csr_array, csr_array]:
        moved = matrix_changes(structure, unit)
        return moved.mass, moved.damping, moved.stiffness

    groups = [part.elements for part in plant.parts if part.quantity == "stiffness" and len(part.elements) > 1]
    single = [(number,) for number in range(1, len(structure.elements) + 1)]
    for numbers in [*single, *groups]:
        build = _builder(lambda n, factor: StiffnessChange(n, factor), numbers)
        unit = changes(StiffnessChange(numbers, 2.0))
        found.append(
            Candidate("stiffness_change", build(1.0).location, ("factor",), build, (1.0,), (0.5,), (0.0,), changes=unit)
        )
    for numbers in [*single, *groups]:
        if not AxialForce(numbers, 1.0).faults(structure):
            build = _builder(lambda n, force: AxialForce(n, force), numbers)
            unit = changes(AxialForce(numbers, 1.0))
            width = _felt_force(plant, unit[2])
            found.append(
                Candidate(
                    "axial_force", build(1.0).location, ("force",), build, (0.0,), (width,), infinite, changes=unit
                )
            )
    diagonal = plant.mass.diagonal()
    masses = {node: float(diagonal[row]) for row, node, moves in _free_nodes(plant) if moves}
    usual = 0.5 * float(np.mean(list(masses.values()))) if plant.is_chain else HEAVY * sum(masses.values())
    for node, mass in masses.items():
        build = _builder(lambda n, mass: AddedMass(n, mass), node)
        least = (-0.95 * mass,)
        unit = (_diagonal(plant, np.flatnonzero((dofs.node == node) & (dofs.direction != "rz"))), nothing, nothing)
        found.append(Candidate("added_mass", {"node": node}, ("mass",), build, (0.0,), (usual,), least, changes=unit))
    for place in places(plant):
        scale = _scale(plant, place, motion)
        direction: Any = place.direction
        if len(place.nodes) == 1:
            build = _builder(lambda n, k, d=direction: SupportSpring(n, d, k), place.nodes[0])
            spring = _outer(place.pull)
            unit = (nothing, csr_array(structure.damping.stiffness_factor * spring), spring)
            stiff = (0.5 * scale.stiffness,)
            found.append(
                Candidate(
                    "support_spring",
                    place.location,
                    ("stiffness",),
                    build,
                    (0.0,),
                    stiff,
                    infinite,
                    changes=unit,
                    twins=place.twins,
                )
            )
        build = _builder(lambda n, c, d=direction: PointDamper(n, d, c), place.nodes)
        unit = (nothing, _outer(place.pull), nothing)
        found.append(
            Candidate(
                "point_damper",
                place.location,
                ("coefficient",),
                build,
                (0.0,),
                (scale.coefficient,),
                infinite,
                changes=unit,
                twins=place.twins,
            )
        )
    return found + _released(plant)


def _outer(pull: FloatArray) -> csr_array:
    """Return b b^T of a place's coefficients, sparse."""
    column = csr_array(pull[:, None])
    return csr_array(column @ column.T)


def _diagonal(plant: Plant, rows: IntArray) -> csr_array:
    return csr_array((np.ones(len(rows)), (rows, rows)), shape=plant.mass.shape)


def _released(plant: Plant) -> list[Candidate]:
    """Return the supports that may be too soft, each by its compliance: 0 as drawn."""
    found = []
    for row in np.flatnonzero(~plant.dofs.free):
        node, direction = int(plant.dofs.node[row]), str(plant.dofs.direction[row])
        shape = plant.released(int(row))
        soft = 1 / float(shape @ (plant.stiffness @ shape))  # of the structure itself, when this support gives
        here = _diagonal(plant, np.array([row]))
        nothing = csr_array(plant.mass.shape)
        damped = csr_array(plant.structure.damping.stiffness_factor * here)  # as all that is stiff
        found.append(
            Candidate(
                "support_spring",
                {"node": node, "direction": direction},
                ("stiffness",),
                _builder(lambda n, compliance, d=direction: SupportSpring(n, d, 1 / compliance), node),
                (0.0,),
                (0.5 * soft,),
                (FIRM * soft,),
                ((10 * FIRM * soft,),),
                changes=(nothing, damped, here),
                released=int(row),
            )
        )
    return found


def _free_nodes(plant: Plant) -> list[tuple[int, int, bool]]:
    """Return row, node and whether a mass there is felt, of each node's most mobile translation."""
    shapes, dofs = plant.modes[1], plant.dofs
    found = []
    for node in range(1, len(plant.structure.nodes) + 1):
        rows = np.flatnonzero((dofs.node == node) & (dofs.direction != "rz"))
        if len(rows):
            row = int(rows[np.argmax(np.abs(shapes[rows]).max(axis=1))])
            found.append((row, node, bool(dofs.free[row]) and plant.mass.diagonal()[row] > 0))
    return found


def _felt_force(plant: Plant, stiffness: csr_array) -> float:
    """Return the axial force (N) that changes the square of some mode's frequency by 30 %: a third of buckling."""
    omega, shapes = plant.modes
    softened = np.abs(np.einsum("di,di->i", shapes, stiffness @ shapes))
    return 0.3 * float(np.min(omega**2 / np.maximum(softened, 1e-12 * omega**2)))


def _modes(plant: Plant) -> list[Candidate]:
    return [
        Candidate(
            "modal_damping",
            {"modes": [mode + 1]},
            ("ratio",),
            _builder(lambda n, ratio: ModalDamping((n,), ratio), mode + 1),
            (float(ratio),),
            (0.05,),
            (0.0,),
            mode=mode,
        )
        for mode, ratio in enumerate(plant.own_ratios)
    ]


def _laws(plant: Plant, motion: Motion) -> list[Candidate]:
    found = []
    positive = (0.0,)
    for place in places(plant):
        nodes, direction, pull = place.nodes, cast(Direction, place.direction), place.pull
        scale = _scale(plant, place, motion)
        stiffness, damping = scale.stiffness, scale.coefficient
        u, v = motion.displacement @ pull, motion.velocity @ pull
        size, rate = float(np.std(u)), float(np.std(v))

        def law(
            kind: str,
            names: tuple[str, ...],
            make: Callable[..., Cause],
            width: tuple[float, ...],
            lower: tuple[float, ...],
            starts: tuple[tuple[float, ...], ...] = (),
            here: Place = place,
            **more: int,
        ) -> Candidate:
            return Candidate(
                kind,
                here.location | more,
                names,
                make,
                (0.0,) * len(names),
                width,
                lower,
                starts,
                pull=here.pull,
                twins=tuple(twin | more for twin in here.twins),
            )

        build = _builder(lambda n, k, d=direction: CubicSpring(n, d, k), nodes)
        found.append(law("cubic_spring", ("stiffness",), build, (stiffness / (3 * size**2),), (-np.inf,)))
        build = _builder(lambda n, c, d=direction: QuadraticDamper(n, d, c), nodes)
        found.append(law("quadratic_damper", ("coefficient",), build, (damping / rate,), positive))
        build = _builder(lambda n, f, d=direction, creep=CREEP * rate: CoulombFriction(n, d, f, creep), nodes)
        found.append(law("coulomb_friction", ("force",), build, (0.3 * damping * rate,), positive))
        for side in (1, -1):
            most = max(float(np.quantile(side * u, 0.999)), 1e-3 * size)
            build = _builder(lambda n, k, gap, d=direction, s=side: GapStop(n, d, gap, k, s), nodes)
            starts = tuple((SMALL * stiffness, reach * most) for reach in REACHES)
            found.append(
                law("gap_stop", ("stiffness", "gap"), build, (stiffness, size), (0.0, 1e-3 * size), starts, side=side)
            )
    return found + _slack_cables(plant, motion)


def _slack_cables(plant: Plant, motion: Motion) -> list[Candidate]:
    found = []
    for number in range(1, len(plant.structure.elements) + 1):
        effect = SlackCable(number, 1.0)
        law = None if effect.faults(plant.structure) else effect.law(plant.structure)
        if law is not None:
            pull = plant.pull(law)
            u = motion.displacement @ pull
            most = max(float(np.quantile(-u, 0.999)), 1e-3 * float(np.std(u))) * law.stiffness
            found.append(
                Candidate(
                    "slack_cable",
                    {"element": number},
                    ("pretension",),
                    _builder(lambda n, pretension: SlackCable(n, pretension), number),
                    (2.0 * most,),  # never slack
                    (most,),
                    (1e-3 * most,),
                    tuple((reach * most,) for reach in REACHES),
                    scalable=False,
                    pull=pull,
                )
            )
    return found


def _oscillators(plant: Plant) -> list[Candidate]:
    return [
        Candidate(
            "harmonic_force",
            place.location,
            ("frequency",),
            _builder(lambda n, f, d=place.direction: HarmonicForce(n, d, 1.0, f), place.nodes[0]),
            (0.0,),
            (1.0,),
            (1e-6,),
            pull=place.pull,
            oscillator=True,
            twins=place.twins,
        )
        for place in places(plant)
        if len(place.nodes) == 1
    ]


def _sensors(dataset: Dataset, motion: Motion, measured: tuple[int, ...]) -> list[Candidate]:
    found = []
    period = 2 * np.pi * float(np.std(motion.displacement) / np.std(motion.velocity))
    for position, column in enumerate(measured):
        name, where = dataset.sensors[column].name, {"sensor": dataset.sensors[column].name}
        data = [recording.data[..., column] for recording in dataset.select("train")]
        size = float(np.mean([part.std() for part in data]))
        time = max(part.shape[-1] for part in data) / dataset.sampling_rate
        infinite = (-np.inf,)
        for kind, word, cause, neutral, width in (
            ("sensor_gain", "factor", SensorGain, 1.0, 0.3),
            ("sensor_delay", "delay", SensorDelay, 0.0, 0.03 * period),
            ("sensor_drift", "slope", SensorDrift, 0.0, size / time),
        ):
            build = _builder(lambda n, value, made=cause: made(n, value), name)
            found.append(Candidate(kind, where, (word,), build, (neutral,), (width,), infinite, sensor=position))
    return found


def _steps(plant: Plant) -> list[Candidate]:
    known = plant.integration
    return [] if known is None else [Candidate("time_integration", {}, (), lambda: known, (), (), ())]


def _builder(make: Callable[..., Cause], place: Any) -> Callable[..., Cause]:
    """Return ``make`` with its place given: a loop's variable must be bound when the function is made."""
    return lambda *values: make(place, *values)
