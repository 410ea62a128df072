"""Runs of Exudyn systems: rest under loads, motion after a release, and many free motions of one set of matrices."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    LoadCoordinate,
    NodeGenericODE2,
    ObjectGenericODE2,
    SensorNode,
)

from fe_models.arrays import FloatArray
from fe_models.causes import ForceLaw, LawWithMemory, MemorylessLaw
from fe_models.causes.force_law import SlowPull
from fe_models.causes.laws import with_parts
from fe_models.errors import InputError, raise_faults
from fe_models.exudyn.item_matrices import element_vector, whole_system
from fe_models.exudyn.items import (
    ExudynSystem,
    Options,
    add_drive,
    add_force_law,
    add_law_with_memory,
    add_spread_law,
    coordinate_marker,
    ground_marker,
    new_system,
)
from fe_models.mesh import Mesh
from fe_models.structure import Spring, Structure

LOAD_STEPS = 5
STATIC_TOLERANCE = 1e-6  # of Newton's first residual in each load step
# Of the accelerations at a step and the two before and after it: their sum takes away what changes sign at every step
# and leaves polynomials as they are up to order 3; at an end and the step before it, from there inwards, up to order 2.
SMOOTHING_WEIGHTS = np.array([-1, 4, 10, 4, -1]) / 16
END_SMOOTHING_WEIGHTS = np.array([[14, 6, -6, 2], [2, 10, 6, -2]]) / 16
MEMORY_TOLERANCE = 0.02  # of what a law with memory can carry: how far a step may lead beyond
SMALLEST_TOLERANCE = 1e-10  # N, Exudyn's own, for structures of springs alone


@dataclass(frozen=True)
class Steps:
    """``outputs`` equal intervals of ``interval`` s, each of ``per_output`` equal steps of the integrator."""

    interval: float
    outputs: int
    per_output: int

    @property
    def duration(self) -> float:
        """The time simulated (s)."""
        return self.interval * self.outputs


def static_displacement(
    structure: Structure,
    mesh: Mesh,
    load: FloatArray,
    slack: bool,
    start: FloatArray | None = None,
    laws: tuple[ForceLaw, ...] = (),
    reference: FloatArray | None = None,
) -> FloatArray:
    """Return the displacement (dof,) at rest under ``load`` (dof,) in N, with prestress and large displacements.

    ``slack`` lets cables go slack. ``start`` (dof,) is where the iteration begins, by default the drawn geometry. The
    force ``laws`` act on elongations from the displacement ``reference`` (dof,).
    """
    pulled = tuple(SlowPull(law) if isinstance(law, LawWithMemory) else law for law in laws)
    system = whole_system(structure, mesh, Options(structure.damping, slack=slack), pulled, reference)
    _add_loads(system, structure, mesh, load)
    system.mbs.Assemble()
    if start is not None:
        system.mbs.systemData.SetODE2Coordinates(start.tolist(), exu.ConfigurationType.Initial)
    settings = quiet_settings()
    settings.staticSolver.numberOfLoadSteps = 1 if start is not None else LOAD_STEPS
    settings.staticSolver.newton.relativeTolerance = STATIC_TOLERANCE
    settings.staticSolver.newton.absoluteTolerance = _force_rounding(structure, mesh)
    settings.staticSolver.verboseMode = 0
    try:
        system.mbs.SolveStatic(settings, updateInitialValues=True, showHints=False)
        # Newton stops at a share of its first residual: once more from there, and the error falls from 1e-3 to 1e-11.
        settings.staticSolver.numberOfLoadSteps = 1
        system.mbs.SolveStatic(settings, updateInitialValues=True, showHints=False)
    except exu.SolverError:
        raise InputError(
            f"structure {structure.name!r}: no state at rest found under its loads and prestress. It may buckle or be "
            "a mechanism: lower the loads, raise the prestress, or refine the beams"
        ) from None
    displacement = system.mbs.systemData.GetODE2Coordinates(exu.ConfigurationType.Initial)
    return np.where(mesh.dofs.free, displacement, 0.0)  # supports keep roundings of 1e-26


def motion_after_release(
    structure: Structure,
    mesh: Mesh,
    load: FloatArray,
    start: FloatArray,
    modal_damping: FloatArray | None,
    steps: Steps,
    advance: Callable[[], object],
    laws: tuple[ForceLaw, ...] = (),
    reference: FloatArray | None = None,
    drive: Callable[[float], FloatArray] | None = None,
) -> FloatArray:
    """Return displacement, velocity and acceleration, (3, time, dof), from rest at ``start`` under the dead ``load``.

    And under a ``drive`` (dof,) of time (s), N, where one is given.

    Trapezoidal rule (Newmark, constant average acceleration), which damps nothing itself, so that what a release starts
    of the highest modes goes on as accelerations that change sign with every step: see `SMOOTHING_WEIGHTS`.
    ``modal_damping`` (dof, dof) is added as it is. ``advance`` is called once an output, for a progress bar. The force
    ``laws`` act on elongations from the displacement ``reference`` (dof,).
    """
    system = whole_system(structure, mesh, Options(structure.damping), laws, reference)
    _add_loads(system, structure, mesh, load)
    if modal_damping is not None:
        nodes = list(range(len(mesh.coordinates)))
        system.mbs.AddObject(
            ObjectGenericODE2(nodeNumbers=nodes, massMatrix=0 * modal_damping, dampingMatrix=modal_damping)
        )
    if drive is not None:
        add_drive(system, list(range(len(mesh.coordinates))), drive)
    system.mbs.Assemble()
    data = system.mbs.systemData
    data.SetODE2Coordinates(start.tolist(), exu.ConfigurationType.Initial)
    rest = np.zeros(len(start)) if reference is None else reference
    _remember(system, [(law, float(mesh.dofs.pull(law.pulls) @ (start - rest))) for law in laws])
    response = np.zeros((3, steps.outputs + 1, len(start)))
    largest = np.zeros(len(system.memories))
    taken = -1  # Exudyn calls back before the first step, too

    def record(_system: Any, _time: float) -> bool:
        nonlocal taken
        taken += 1
        output, rest = divmod(taken, steps.per_output)
        if rest == 0 and output <= steps.outputs:
            vectors = data.GetODE2Coordinates(), data.GetODE2Coordinates_t()
            response[:2, output] = np.where(mesh.dofs.free, vectors, 0.0)
            largest[:] = np.maximum(largest, np.abs(data.GetODE1Coordinates()))
            advance()
        for near, weight in _calmed_by(taken, steps):
            response[2, near] += weight * np.where(mesh.dofs.free, data.GetODE2Coordinates_tt(), 0.0)
        return True

    system.mbs.SetPostStepUserFunction(record)
    settings = _dynamic_settings(steps, "newmark")
    settings.timeIntegration.newton.absoluteTolerance = _force_rounding(structure, mesh)
    _integrate(system, settings, "newmark", steps)
    _check_memories(list(laws), largest, steps)
    return response


def _calmed_by(step: int, steps: Steps) -> list[tuple[int, float]]:
    """Return the outputs that the accelerations of a ``step`` belong to, each with their weight there.

    The first, before any step is taken, is as it is; so are all of so few steps that nothing can be distinguished from
    others.
    """
    last, reach = steps.outputs * steps.per_output, len(END_SMOOTHING_WEIGHTS[0]) - 1
    centres = range(max(step - reach, 0), min(step + reach, last) + 1) if step <= last else ()
    weights = {centre: _calming(centre, last).get(step, 0.0) for centre in centres if centre % steps.per_output == 0}
    return [(centre // steps.per_output, weight) for centre, weight in weights.items() if weight]


def _calming(centre: int, last: int) -> dict[int, float]:
    """Return the weights, by step, of the accelerations that estimate those at the step ``centre`` of 0 to ``last``."""
    if centre == 0 or last < len(END_SMOOTHING_WEIGHTS[0]) - 1:
        return {centre: 1.0}
    for number, weights in enumerate(END_SMOOTHING_WEIGHTS.tolist()):
        if centre == number:
            return dict(enumerate(weights))
        if centre == last - number:
            return {last - away: weight for away, weight in enumerate(weights)}
    return dict(enumerate(SMOOTHING_WEIGHTS.tolist(), start=centre - 2))


class FreeMotion:
    """Motion of M u'' + C u' + K u + force laws = a drive, by default 0, from any initial state.

    Built once, run many times.
    """

    def __init__(
        self,
        mass: FloatArray,
        damping: FloatArray,
        stiffness: FloatArray,
        laws: tuple[tuple[ForceLaw, FloatArray], ...],
        steps: Steps,
        integrator: Literal["rk67", "newmark"],
        drive: Callable[[float], FloatArray] | None = None,
    ) -> None:
        """Build the system: matrices (free, free); each force law with its coefficients (free,); a ``drive`` (free,) of
        time (s), N.
        """
        zeros = [0.0] * len(mass)
        self._system = new_system(("x",))
        mbs = self._system.mbs
        node = mbs.AddNode(
            NodeGenericODE2(
                referenceCoordinates=zeros,
                initialCoordinates=zeros,
                initialCoordinates_t=zeros,
                numberOfODE2Coordinates=len(mass),
            )
        )
        mbs.AddObject(
            ObjectGenericODE2(nodeNumbers=[node], massMatrix=mass, dampingMatrix=damping, stiffnessMatrix=stiffness)
        )
        self._laws = laws
        for law, pull in laws:
            self._add_law(law, node, pull)
        if drive is not None:
            add_drive(self._system, [node], drive)
        kinds = (exu.OutputVariableType.Coordinates, exu.OutputVariableType.Coordinates_t)
        self._sensors = [
            mbs.AddSensor(SensorNode(nodeNumber=node, outputVariableType=kind, storeInternal=True)) for kind in kinds
        ]
        self._memories = [
            mbs.AddSensor(SensorNode(nodeNumber=memory, outputVariableType=kinds[0], storeInternal=True))
            for memory in self._system.memories
        ]
        mbs.Assemble()
        self._steps, self._integrator = steps, integrator
        self._settings = _dynamic_settings(steps, integrator)

    def _add_law(self, law: ForceLaw, node: Any, pull: FloatArray) -> None:
        """Add a law on one coordinate, or on the difference of two, evaluated by Exudyn; any other by Python."""
        if isinstance(law, LawWithMemory):
            add_law_with_memory(self._system, law, [node], pull, np.arange(len(pull)))
            return
        assert isinstance(law, MemorylessLaw)
        marker = {float(pull[row]): coordinate_marker(self._system, node, int(row)) for row in np.flatnonzero(pull)}
        if len(marker) == np.count_nonzero(pull) and marker.keys() <= {1.0, -1.0}:
            ground = ground_marker(self._system)
            add_force_law(self._system, law, [marker.get(-1.0, ground), marker.get(1.0, ground)])
        else:
            add_spread_law(self._system, law, [node], pull)

    def run(self, displacement: FloatArray, velocity: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return displacement and velocity, each (time, free), from the given initial ones (free,); and what the laws
        with memory have of them, z (time, law).
        """
        data = self._system.mbs.systemData
        data.SetODE2Coordinates(displacement.tolist(), exu.ConfigurationType.Initial)
        data.SetODE2Coordinates_t(velocity.tolist(), exu.ConfigurationType.Initial)
        _remember(self._system, [(law, float(pull @ displacement)) for law, pull in self._laws])
        _integrate(self._system, self._settings, self._integrator, self._steps)
        x, v = (self._stored(sensor) for sensor in self._sensors)
        remembered = np.hstack([np.zeros((len(x), 0)), *(self._stored(sensor) for sensor in self._memories)])
        _check_memories([law for law, _ in self._laws], np.abs(remembered).max(axis=0), self._steps)
        return x, v, remembered

    def _stored(self, sensor: Any) -> FloatArray:
        return np.asarray(self._system.mbs.GetSensorStoredData(sensor))[:, 1:]


def _remember(system: ExudynSystem, laws: list[tuple[ForceLaw, float]]) -> None:
    """Begin with what each law with memory has after a slow pull to its elongation (m)."""
    begun = [float(law.pulled_to(elongation)) for law, elongation in laws if isinstance(law, LawWithMemory)]
    if begun:
        system.mbs.systemData.SetODE1Coordinates(begun, exu.ConfigurationType.Initial)


def _check_memories(laws: list[ForceLaw], largest: FloatArray, steps: Steps) -> None:
    """Refuse steps in which the ``largest`` z (law,) of laws with memory went beyond what these can have."""
    step = steps.interval / steps.per_output
    remembering = [law for law in laws if isinstance(law, LawWithMemory)]
    raise_faults(
        f"a step of {step:.3g} s is too long for the {law.kind}, which would carry {own / law.largest:.2g} times what"
        " it can: choose a smaller step"
        for law, own in zip(remembering, largest.tolist(), strict=True)
        if own > (1 + MEMORY_TOLERANCE) * law.largest
    )


def _integrate(system: ExudynSystem, settings: Any, integrator: Literal["rk67", "newmark"], steps: Steps) -> None:
    step = steps.interval / steps.per_output
    solver = exu.DynamicSolverType.RK67 if integrator == "rk67" else exu.DynamicSolverType.TrapezoidalIndex2
    remedy = f"choose a step smaller than {step:.3g} s"
    try:
        system.mbs.SolveDynamic(settings, solverType=solver, showHints=False)
    except exu.SolverError:
        raise InputError(f"the simulation found no solution in one of its time steps: {remedy}") from None
    if not np.isfinite(system.mbs.systemData.GetODE2Coordinates()).all():
        raise InputError(f"the simulation grew beyond all bounds: {remedy}, or see whether an effect feeds energy in")


def _add_loads(system: ExudynSystem, structure: Structure, mesh: Mesh, load: FloatArray) -> None:
    per_node = len(structure.directions)
    for row in np.flatnonzero(np.where(mesh.dofs.free, load, 0.0)):
        marker = coordinate_marker(system, int(row) // per_node, int(row) % per_node)
        system.mbs.AddLoad(LoadCoordinate(markerNumber=marker, load=float(load[row])))


def _force_rounding(structure: Structure, mesh: Mesh) -> float:
    """Return what rounding leaves of the forces (N), below which no iteration gets.

    Strains are differences of coordinates: eps span / length of them is noise, times the stiffness E A or 12 E I / L^2.
    """
    span = float(np.abs(mesh.coordinates).max())
    noise = [0.0]
    drawn = with_parts(structure).elements[: len(structure.elements)]
    for number, element in enumerate(drawn, start=1):
        if not isinstance(element, Spring):
            length = float(np.hypot(*element_vector(structure, number)))
            shear = 12 * element.section.bending_stiffness / length**2
            noise.append(max(element.section.axial_stiffness, shear) * span / length)
    return max(20 * float(np.finfo(float).eps) * max(noise), SMALLEST_TOLERANCE)


def quiet_settings() -> Any:
    """Return settings that write nothing anywhere and use sparse matrices."""
    settings = exu.SimulationSettings()
    settings.solution.file.write = False
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    return settings


def _dynamic_settings(steps: Steps, integrator: Literal["rk67", "newmark"]) -> Any:
    settings = quiet_settings()
    settings.solution.sensors.writePeriod = steps.interval
    integration = settings.timeIntegration
    integration.endTime = steps.duration
    integration.numberOfSteps = steps.outputs * steps.per_output
    integration.automaticStepSize = False
    integration.adaptiveStep = False  # the samples must lie on their own equal grid
    integration.verboseMode = 0
    return settings
