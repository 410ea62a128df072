"""Simulation in Exudyn: pull-and-release of a nonlinear structure, and free motion of a linear model with effects."""

from dataclasses import dataclass, replace
from math import ceil
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eigh

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.causes import Effect, ForceLaw
from fe_models.causes.laws import force_laws
from fe_models.damping import full_damping
from fe_models.dof_map import DofMap
from fe_models.drive import Drive
from fe_models.errors import InputError, raise_faults
from fe_models.items import gravity_load
from fe_models.joined_laws import Joined, joined_laws, law_forces
from fe_models.linear import LinearModel
from fe_models.linear_checks import dof_name
from fe_models.mesh import mesh
from fe_models.mode_count import mode_count
from fe_models.progress import progress_bar
from fe_models.response import Response
from fe_models.simulation_size import length_faults
from fe_models.statics import STANDARD_GRAVITY, PointLoad, load_vector, rest_state
from fe_models.structure import Structure
from fe_models.time_step import Integrator, free_step, time_step

if TYPE_CHECKING:
    from fe_models.exudyn.solve import Steps


@dataclass(frozen=True)
class ReleaseConfig:
    """How a release is simulated.

    ``duration`` (s); ``sampling_rate`` (Hz) of the response, well above what is measured later, so that a low-pass can
    act before decimation; ``step`` (s) at most of the integrator, left out: what natural frequencies up to a tenth of
    the sampling rate need (`time_step`); ``gravity`` (m/s^2) along -y.

    After two seconds of the bridge a step of 1e-3 s is off by 0.3 % in displacements and 3 % in unfiltered
    accelerations, half the step by a quarter of that.
    """

    duration: float = 20.0
    sampling_rate: float = 500.0
    step: float | None = None
    gravity: float = STANDARD_GRAVITY


def simulate_release(
    structure: Structure, pulls: tuple[PointLoad, ...], config: ReleaseConfig | None = None, progress: bool = True
) -> Response:
    """Return the motion about the state at rest after the ``pulls`` are let go.

    Weight and prestress act throughout; with the pulls the structure first comes to rest, M u'' = 0, and at t = 0 they
    vanish. Displacements are large, cables go slack, effects act: force laws on elongations from the state at rest
    without pulls, what depends on time from t = 0 on. Rayleigh damping is the material's and follows large rotations;
    modal ratios hold for the modes at the state at rest. Without damping of high frequencies (a stiffness factor, or
    modal ratios) the response depends on the step however small.
    """
    from fe_models.exudyn.solve import motion_after_release  # loads Exudyn only where it is needed

    config = config or ReleaseConfig()
    step = config.step if config.step is not None else time_step(structure, config.sampling_rate / 10).step
    steps = _steps(config.duration, config.sampling_rate, step)
    pull = load_vector(structure, pulls)
    if not pull.any():
        raise InputError("nothing pulls the structure, so that its release moves nothing: give a load with a force")
    rest = rest_state(structure, config.gravity)
    pulled = rest_state(structure, config.gravity, pulls)
    tangent = linearise(structure, rest)
    with progress_bar("release", steps.outputs + 1, "sample", shown=None if progress else False) as bar:
        motion = motion_after_release(
            structure,
            mesh(structure),
            gravity_load(structure, config.gravity),
            pulled,
            _modal_damping(tangent),
            steps,
            bar.update,
            force_laws(structure),
            rest,
        )
    return Response(_time(steps), motion[0] - rest, motion[1], motion[2], tangent.dofs)


@dataclass(frozen=True)
class FreeConfig:
    """How free motion is simulated.

    ``duration`` (s), ``sampling_rate`` (Hz) of the response, ``step`` (s) at most of the ``integrator``: "rk67",
    explicit, of order 6, for chains and small models, or "newmark" (constant average acceleration) for stiff ones.
    Left out: what the highest mode needs (`free_step`).
    """

    duration: float = 50.0
    sampling_rate: float = 10.0
    step: float | None = None
    integrator: Integrator = "rk67"


MAX_USUAL_STEPS = 1_000_000
"""Of one motion, where no step is given: more take many minutes."""
RK67_MAX_PHASE = 1.0
"""Largest omega times step of the explicit integrator: beyond it is inaccurate, soon after unstable."""
IMPLICIT = 'fe_models.simulation.simulate_free with FreeConfig(integrator="newmark")'
LAW_PHASE = 0.5
"""Of what force laws make fastest: where no step is given."""


def simulate_free(
    model: Structure | LinearModel,
    displacement: FloatArray,
    velocity: FloatArray,
    config: FreeConfig | None = None,
    effects: tuple[Effect | ForceLaw, ...] = (),
    progress: bool = True,
) -> Response:
    """Return free motions M u'' + C u' + K u + f(u, u', t) = 0 from many initial states, (realisation, time, dof).

    ``displacement`` and ``velocity``: (realisation, free). f are the force laws of the ``effects`` and, for a
    structure, of its own; all else of a structure is taken as linear (see `assembly.linearise`), linear effects
    included, which matrices alone cannot have. `InputError` for states that do not fit the model and for steps that the
    integrator cannot take.
    """
    config = config or FreeConfig()
    if isinstance(model, Structure):
        structure = model.with_effects(*(effect for effect in effects if isinstance(effect, Effect)))
        others = tuple(effect for effect in effects if not isinstance(effect, Effect))
        model, laws = linearise(structure), force_laws(structure) + others
    else:
        laws = _laws_alone(effects)
    displacement, velocity = _initial_states(model, displacement, velocity)
    return _from_states(model, laws, displacement, velocity, config, progress)


def simulate_driven(
    structure: Structure, drive: Drive, config: FreeConfig | ReleaseConfig | None = None, progress: bool = True
) -> Response:
    """Return the motion from rest under a ``drive``, (time, dof), as long as that is given.

    Of a chain as `simulate_free` does, with a `FreeConfig`; of all else as `simulate_release` does, with a
    `ReleaseConfig`: large displacements about the state at rest under weight and prestress, slack cables, force laws.
    The ``drive`` says how long. Where the base moves, displacements are relative to it, and ``ground`` is its own.
    """
    from fe_models.exudyn.solve import motion_after_release  # loads Exudyn only where it is needed

    if structure.is_chain:
        config = config if isinstance(config, FreeConfig) else FreeConfig(sampling_rate=drive.sampling_rate)
        config = replace(config, duration=drive.duration)
        linear = linearise(structure)
        rest = np.zeros((1, linear.mass.shape[0]))
        moved = _from_states(linear, force_laws(structure), rest, rest, config, progress, drive)
        single = (moved.displacement[0], moved.velocity[0], moved.acceleration[0])
        return Response(moved.time, *single, moved.dofs, drive.ground(moved.time))
    config = config if isinstance(config, ReleaseConfig) else ReleaseConfig()
    step = config.step if config.step is not None else time_step(structure, config.sampling_rate / 10).step
    steps = _steps(drive.duration, config.sampling_rate, step)
    rest = rest_state(structure, config.gravity)
    tangent = linearise(structure, rest)
    with progress_bar("driven motion", steps.outputs + 1, "sample", shown=None if progress else False) as bar:
        motion = motion_after_release(
            structure,
            mesh(structure),
            gravity_load(structure, config.gravity),
            rest,
            _modal_damping(tangent),
            steps,
            bar.update,
            force_laws(structure),
            rest,
            drive.at,
        )
    time = _time(steps)
    return Response(time, motion[0] - rest, motion[1], motion[2], tangent.dofs, drive.ground(time))


def _from_states(
    model: LinearModel,
    laws: tuple[ForceLaw, ...],
    displacement: FloatArray,
    velocity: FloatArray,
    config: FreeConfig,
    progress: bool,
    drive: Drive | None = None,
) -> Response:
    """Return motions from many initial states, each (realisation, free): see `simulate_free`."""
    from fe_models.exudyn.solve import FreeMotion  # loads Exudyn only where it is needed

    mass, damping, stiffness = model.mass.toarray(), full_damping(model), model.stiffness.toarray()
    joined, free = joined_laws(model.dofs, laws), model.dofs.free
    raise_faults(_massless(model))
    step = config.step if config.step is not None else _usual_step(model, config)
    fastest = _fastest(mass, stiffness, joined) if config.integrator == "rk67" else (0.0, 0.0)
    steps = _steps(config.duration, config.sampling_rate, step)
    if config.step is None and (drive is not None or _explicit_faults(*fastest, steps)):  # friction and stops
        step = min([step, *(LAW_PHASE / rate for rate in fastest if rate > 0)])
        if drive is None:
            _refuse_long(config.duration, step)
        steps = _steps(config.duration, config.sampling_rate, step)
    raise_faults(_explicit_faults(*fastest, steps))
    push = None if drive is None else lambda time: drive.at(time)[free]
    run = FreeMotion(mass, damping, stiffness, joined, steps, config.integrator, push)
    motions = []
    with progress_bar("free motion", len(displacement), "motion", shown=None if progress else False) as bar:
        for x0, v0 in zip(displacement, velocity, strict=True):
            motions.append(run.run(x0, v0))
            bar.update()
    x, v, z = (np.stack(part) for part in zip(*motions, strict=True))  # each (realisation, time, free or law)
    force = v @ damping.T + x @ stiffness.T + law_forces(joined, x, v, z, _time(steps))
    if drive is not None:
        force -= drive.at(_time(steps))[:, free]
    a = -np.linalg.solve(mass, force.reshape(-1, len(mass)).T).T.reshape(force.shape)
    displacements, velocities, accelerations = (_expand(model.dofs, part) for part in (x, v, a))
    return Response(_time(steps), displacements, velocities, accelerations, model.dofs)


def _usual_step(model: LinearModel, config: FreeConfig) -> float:
    """Return the step that all modes need; `InputError` where that is so short that nobody would wait."""
    step = free_step(model, config.integrator)
    _refuse_long(config.duration, step)
    return step


def _refuse_long(duration: float, step: float) -> None:
    count = duration / step
    if count > MAX_USUAL_STEPS:
        raise InputError(
            f"to follow all modes and effects takes steps of {step:.2g} s, {count:.1g} in {duration:g} s: simulate a"
            f" shorter time; or give a step, in Python, to {IMPLICIT}, which leaves out what modes beyond it do"
        )


def _steps(duration: float, sampling_rate: float, step: float) -> "Steps":
    """Return the grid of outputs, each interval split into the fewest equal steps of at most ``step``."""
    from fe_models.exudyn.solve import Steps

    raise_faults(length_faults(duration, sampling_rate, step))
    interval = 1 / sampling_rate
    outputs = round(duration * sampling_rate)
    if outputs < 1:
        raise InputError(f"duration = {duration} s is shorter than one sample at {sampling_rate} Hz")
    return Steps(interval, outputs, max(ceil(interval / step - 1e-9), 1))


def _time(steps: "Steps") -> FloatArray:
    return np.linspace(0.0, steps.duration, steps.outputs + 1)


def _modal_damping(tangent: LinearModel) -> FloatArray | None:
    """Return the damping matrix (dof, dof) of the modal ratios alone, None where there are none."""
    if not tangent.has_modal_damping:
        return None
    modal = full_damping(tangent) - tangent.damping.toarray()
    free = tangent.dofs.free_rows
    matrix = np.zeros((len(tangent.dofs), len(tangent.dofs)))
    matrix[np.ix_(free, free)] = modal
    return matrix


def _initial_states(
    model: LinearModel, displacement: FloatArray, velocity: FloatArray
) -> tuple[FloatArray, FloatArray]:
    free = model.mass.shape[0]
    states = {"displacement": np.asarray(displacement, dtype=float), "velocity": np.asarray(velocity, dtype=float)}
    faults = [
        f"initial {name} has shape {values.shape}; expected (realisation, {free}), a row for each motion"
        for name, values in states.items()
        if values.ndim != 2 or values.shape[1] != free
    ]
    faults += [f"initial {name} is not finite" for name, values in states.items() if not np.isfinite(values).all()]
    if not faults and len(states["displacement"]) != len(states["velocity"]):
        faults = [f"{len(displacement)} initial displacements but {len(velocity)} initial velocities"]
    if not faults and len(displacement) == 0:
        faults = ["there is no initial state to start from"]
    raise_faults(faults)
    return states["displacement"], states["velocity"]


def _fastest(mass: FloatArray, stiffness: FloatArray, laws: Joined) -> tuple[float, float]:
    """Return the highest natural frequency (rad/s) and the largest rate of decay (1/s) that explicit steps must follow.

    With the largest slopes that the force laws know of: a stop in contact, friction at rest.
    """
    stiffest = stiffness + sum(law.largest_slopes[0] * np.outer(pull, pull) for law, pull in laws)
    dampest = sum((law.largest_slopes[1] * np.outer(pull, pull) for law, pull in laws), np.zeros_like(mass))
    last = [len(mass) - 1] * 2
    highest = np.sqrt(eigh(stiffest, mass, eigvals_only=True, subset_by_index=last)[0])
    fastest = eigh(dampest, mass, eigvals_only=True, subset_by_index=last)[0]
    return float(highest), float(fastest)


def _massless(model: LinearModel) -> list[str]:
    """Return a fault where motion has no mass: its acceleration follows from no force."""
    size, modes = model.mass.shape[0], mode_count(model)
    if modes == size:
        return []
    bare = [dof_name(model.dofs, row) for row in np.flatnonzero(model.mass.diagonal() <= 0)[:5]]
    where = f" ({', '.join(bare)}{', ...' if size - modes > 5 else ''})" if bare else ""
    return [f"{size - modes} of {size} free degrees of freedom have no mass{where}: free motion needs some at each"]


def _explicit_faults(highest: float, fastest: float, steps: "Steps") -> list[str]:
    """Return why steps of the explicit integrator are too long for what is `_fastest`."""
    step = steps.interval / steps.per_output
    if highest * step > RK67_MAX_PHASE:
        return [
            f"a step of {step:.3g} s is too long for the highest mode ({highest / (2 * np.pi):.4g} Hz): choose at most"
            f" {RK67_MAX_PHASE / highest:.2g} s, or, in Python, {IMPLICIT}"
        ]
    if fastest * step > RK67_MAX_PHASE:
        return [
            f"a step of {step:.3g} s is too long for an effect that at rest damps within {1 / fastest:.2g} s: choose"
            f" at most {RK67_MAX_PHASE / fastest:.2g} s, a larger regularisation, or, in Python, {IMPLICIT}"
        ]
    return []


def _laws_alone(effects: tuple[Effect | ForceLaw, ...]) -> tuple[ForceLaw, ...]:
    """Return effects that need no structure; `InputError` with the others."""
    linear = dict.fromkeys(effect.kind for effect in effects if not isinstance(effect, ForceLaw))
    raise_faults(f"{kind} changes a structure, and matrices alone have none: give a structure" for kind in linear)
    return tuple(effect for effect in effects if isinstance(effect, ForceLaw))


def _expand(dofs: DofMap, free_values: FloatArray) -> FloatArray:
    """Return (..., free) as (..., dof) with zeros at the supports."""
    full = np.zeros((*free_values.shape[:-1], len(dofs)))
    full[..., dofs.free] = free_values
    return full
