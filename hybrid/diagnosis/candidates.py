"""All causes at all places of a chain: what each changes, its parameters, where a search starts and how far it goes."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.linalg import eigh

from fe_models.dofs import FloatArray
from fe_models.effects import (
    AddedMass,
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
from fe_models.structure import Spring
from hybrid.diagnosis.plant import Plant

CREEP = 0.01  # of the rms rate at its place: the rate below which friction is taken as a dashpot
SMALL = 1e-3  # of a prior width: the step at which a response counts as of first order
REACHES = (0.1, 0.25, 0.45, 0.65, 0.85)  # of the largest elongation: where a search for a gap starts


@dataclass(frozen=True)
class Candidate:
    """One kind of cause at one place.

    ``build`` makes the cause from its parameters (of arrays, one of arrays). ``names``: their words; ``neutral``:
    values at which it does nothing; ``width``: prior standard deviations about them; ``lower``: bounds; ``starts``:
    values at which a search may begin; with ``scalable`` the first of them is small, and the score test finds its size.
    The cause is felt by what of the following is set: ``changes`` dM, dC, dK (3, dof, dof) for each unit of its
    parameter, ``mode`` (from 0), ``pull`` (dof,) of a force law (with ``element`` where the law needs an element's
    stiffness) or of an ``oscillator``, ``sensor`` (position among the measured ones), or nothing (the time steps).
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
    changes: FloatArray | None = field(default=None, compare=False, repr=False)
    mode: int | None = None
    pull: FloatArray | None = field(default=None, compare=False, repr=False)
    element: int | None = None
    oscillator: bool = False
    sensor: int | None = None

    @property
    def first_starts(self) -> tuple[tuple[float, ...], ...]:
        """The ``starts``; where none are given, a small step away from doing nothing."""
        if self.starts or not self.names:
            return self.starts or ((),)
        return (tuple(a + SMALL * b for a, b in zip(self.neutral, self.width, strict=True)),)

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
        *_linear(plant),
        *_modes(plant),
        *_laws(plant, motion),
        *_oscillators(plant),
        *_sensors(dataset, motion, measured),
        *_steps(plant),
    )


def places(plant: Plant) -> list[tuple[dict[str, Any], tuple[int, ...], FloatArray]]:
    """Return location, nodes and coefficients (dof,) of each node against the ground and of each two joined nodes."""
    structure = plant.structure
    direction = structure.directions[0]
    rows = {int(plant.dofs.node[row]): i for i, row in enumerate(plant.dofs.free_rows)}
    found: list[tuple[dict[str, Any], tuple[int, ...], FloatArray]] = []
    for node, row in rows.items():
        found.append(({"node": node, "direction": direction}, (node,), np.eye(plant.size)[row]))
    pairs = [e.nodes for e in structure.elements if len(e.nodes) == 2 and all(node in rows for node in e.nodes)]
    for first, last in dict.fromkeys((min(pair), max(pair)) for pair in pairs):
        pull = np.eye(plant.size)[rows[last]] - np.eye(plant.size)[rows[first]]
        found.append(({"nodes": [first, last], "direction": direction}, (first, last), pull))
    return found


def _typical(plant: Plant) -> tuple[float, float, float]:
    """Return a mass (kg), a stiffness (N/m) and a damping coefficient (N s/m) of the size that matters here."""
    mass, stiffness = float(np.diag(plant.mass).mean()), float(np.diag(plant.stiffness).mean() / 2)
    return mass, stiffness, 0.2 * float(np.sqrt(mass * stiffness))


def _linear(plant: Plant) -> list[Candidate]:
    structure, free = plant.structure, plant.dofs.free_rows
    mass, stiffness, damping = _typical(plant)
    direction: Any = structure.directions[0]

    def changes(unit: Effect) -> FloatArray:
        moved = matrix_changes(structure, unit)
        return np.array([part.toarray()[np.ix_(free, free)] for part in (moved.mass, moved.damping, moved.stiffness)])

    found = []
    for number in range(1, len(structure.elements) + 1):
        build = _builder(lambda n, factor: StiffnessChange((n,), factor), number)
        unit = changes(StiffnessChange((number,), 2.0))
        found.append(
            Candidate("stiffness_change", {"element": number}, ("factor",), build, (1.0,), (0.5,), (0.0,), changes=unit)
        )
    infinite = (-np.inf,)
    for row, node in enumerate(int(n) for n in plant.dofs.node[free]):
        build = _builder(lambda n, mass: AddedMass(n, mass), node)
        least = (-0.95 * float(plant.mass[row, row]),)
        unit = changes(AddedMass(node, 1.0))
        found.append(
            Candidate("added_mass", {"node": node}, ("mass",), build, (0.0,), (0.5 * mass,), least, changes=unit)
        )
        build = _builder(lambda n, stiffness: SupportSpring(n, direction, stiffness), node)
        unit = changes(SupportSpring(node, direction, 1.0))
        where = {"node": node, "direction": direction}
        found.append(
            Candidate(
                "support_spring", where, ("stiffness",), build, (0.0,), (0.5 * stiffness,), infinite, changes=unit
            )
        )
    for where, nodes, _ in places(plant):
        build = _builder(lambda n, coefficient: PointDamper(n, direction, coefficient), nodes)
        unit = changes(PointDamper(nodes, direction, 1.0))  # type: ignore[arg-type]
        found.append(
            Candidate("point_damper", where, ("coefficient",), build, (0.0,), (damping,), infinite, changes=unit)
        )
    return found


def _modes(plant: Plant) -> list[Candidate]:
    omega2, shapes = eigh(plant.stiffness, plant.mass)
    own = np.einsum("di,de,ei->i", shapes, plant.damping, shapes) / (2 * np.sqrt(omega2)) + plant.ratios
    return [
        Candidate(
            "modal_damping",
            {"modes": [mode + 1]},
            ("ratio",),
            _builder(lambda n, ratio: ModalDamping((n,), ratio), mode + 1),
            (float(own[mode]),),
            (0.05,),
            (0.0,),
            mode=mode,
        )
        for mode in range(plant.size)
    ]


def _laws(plant: Plant, motion: Motion) -> list[Candidate]:
    direction: Any = plant.structure.directions[0]
    _, stiffness, damping = _typical(plant)
    found = []
    for where, nodes, pull in places(plant):
        u, v = motion.displacement @ pull, motion.velocity @ pull
        size, rate = float(np.std(u)), float(np.std(v))
        positive = (0.0,)
        build = _builder(lambda n, k: CubicSpring(n, direction, k), nodes)
        width = (stiffness / (3 * size**2),)
        found.append(Candidate("cubic_spring", where, ("stiffness",), build, (0.0,), width, (-np.inf,), pull=pull))
        build = _builder(lambda n, c: QuadraticDamper(n, direction, c), nodes)
        found.append(
            Candidate(
                "quadratic_damper", where, ("coefficient",), build, (0.0,), (damping / rate,), positive, pull=pull
            )
        )
        build = _builder(lambda n, f, creep=CREEP * rate: CoulombFriction(n, direction, f, creep), nodes)
        width = (0.3 * damping * rate,)
        found.append(Candidate("coulomb_friction", where, ("force",), build, (0.0,), width, positive, pull=pull))
        for side in (1, -1):
            most = max(float(np.quantile(side * u, 0.999)), 1e-3 * size)
            build = _builder(lambda n, k, gap, s=side: GapStop(n, direction, gap, k, s), nodes)
            found.append(
                Candidate(
                    "gap_stop",
                    where | {"side": side},
                    ("stiffness", "gap"),
                    build,
                    (0.0, 0.0),
                    (stiffness, size),
                    (0.0, 1e-3 * size),
                    tuple((SMALL * stiffness, reach * most) for reach in REACHES),
                    pull=pull,
                )
            )
    for number, element in enumerate(plant.structure.elements, start=1):
        if isinstance(element, Spring) and element.stiffness > 0:
            law = SlackCable(number, 1.0).law(plant.structure)
            assert law is not None
            pull = plant.pull(law)
            u = motion.displacement @ pull
            most = max(float(np.quantile(-u, 0.999)), 1e-3 * float(np.std(u))) * element.stiffness
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
                    element=number - 1,
                )
            )
    return found


def _oscillators(plant: Plant) -> list[Candidate]:
    direction: Any = plant.structure.directions[0]
    return [
        Candidate(
            "harmonic_force",
            where,
            ("frequency",),
            _builder(lambda n, f: HarmonicForce(n[0], direction, 1.0, f), nodes),
            (0.0,),
            (1.0,),
            (1e-6,),
            pull=pull,
            oscillator=True,
        )
        for where, nodes, pull in places(plant)
        if len(nodes) == 1
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
