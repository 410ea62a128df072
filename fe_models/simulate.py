"""Simulation in Exudyn: pull-and-release of a nonlinear structure, and free motion of a linear model with effects."""

from dataclasses import dataclass, replace
from math import ceil
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from scipy.linalg import eigh
from tqdm import tqdm

from fe_models.assembly import gravity_load, linearise
from fe_models.damping import full_damping
from fe_models.dofs import DofMap, FloatArray
from fe_models.effects import ConnectorEffect
from fe_models.errors import InputError, raise_faults
from fe_models.linear import LinearModel
from fe_models.mesh import mesh
from fe_models.response import Response
from fe_models.statics import STANDARD_GRAVITY, PointLoad, load_vector, rest_state
from fe_models.structure import Structure

if TYPE_CHECKING:
    from fe_models.exudyn_solve import Steps

BAR_DELAY = 2.0  # s; shorter runs show no progress bar


@dataclass(frozen=True)
class ReleaseConfig:
    """How a release is simulated.

    ``duration`` (s); ``sampling_rate`` (Hz) of the response, well above what is measured later, so that a low-pass can
    act before decimation; ``step`` (s) at most of the integrator: after two seconds of the bridge, 1e-3 is off by
    0.3 % in displacements and 3 % in unfiltered accelerations, half the step by a quarter of that; ``gravity`` (m/s^2)
    along -y.
    """

    duration: float = 20.0
    sampling_rate: float = 500.0
    step: float = 1e-3
    gravity: float = STANDARD_GRAVITY


def simulate_release(
    structure: Structure, pulls: tuple[PointLoad, ...], config: ReleaseConfig | None = None, progress: bool = True
) -> Response:
    """Return the motion about the state at rest after the ``pulls`` are let go.

    Weight and prestress act throughout; with the pulls the structure first comes to rest, M u'' = 0, and at t = 0 they
    vanish. Displacements are large, cables go slack, effects act. Rayleigh damping is the material's and follows large
    rotations; modal ratios hold for the modes at the state at rest. Without damping of high frequencies (a stiffness
    factor, or modal ratios) the response depends on the step however small.
    """
    from fe_models.exudyn_solve import motion_after_release  # loads Exudyn only where it is needed

    config = config or ReleaseConfig()
    steps = _steps(config.duration, config.sampling_rate, config.step)
    pull = load_vector(structure, pulls)
    if not pull.any():
        raise InputError("nothing pulls the structure, so that its release moves nothing: give a load with a force")
    rest = rest_state(structure, config.gravity)
    pulled = rest_state(structure, config.gravity, pulls)
    tangent = linearise(structure, rest)
    with _bar("release", steps.outputs + 1, progress) as bar:
        motion = motion_after_release(
            structure,
            mesh(structure),
            gravity_load(structure, config.gravity),
            pulled,
            _modal_damping(tangent),
            steps,
            advance=bar.update,
        )
    return Response(_time(steps), motion[0] - rest, motion[1], motion[2], tangent.dofs)


@dataclass(frozen=True)
class FreeConfig:
    """How free motion is simulated.

    ``duration`` (s), ``sampling_rate`` (Hz) of the response, ``step`` (s) at most of the ``integrator``: "rk67",
    explicit, of order 6, for chains and small models, or "newmark" (constant average acceleration) for stiff ones.
    0.05 s leaves 1e-7 in the chain of `four_dof`.
    """

    duration: float = 50.0
    sampling_rate: float = 10.0
    step: float = 0.05
    integrator: Literal["rk67", "newmark"] = "rk67"


RK67_REACH = 1.0
"""Largest omega times step of the explicit integrator: beyond it is inaccurate, soon after unstable."""


def simulate_free(
    model: Structure | LinearModel,
    displacement: FloatArray,
    velocity: FloatArray,
    config: FreeConfig | None = None,
    effects: tuple[ConnectorEffect, ...] = (),
    progress: bool = True,
) -> Response:
    """Return free motions M u'' + C u' + K u + f(u, u') = 0 from many initial states, (realisation, time, dof).

    ``displacement`` and ``velocity``: (realisation, free). f are the ``effects`` and, for a structure, its own; all
    else of a structure is taken as linear (see `assembly.linearise`). `InputError` for states that do not fit the model
    and for steps that the integrator cannot take.
    """
    from fe_models.exudyn_solve import FreeMotion  # loads Exudyn only where it is needed

    config = config or FreeConfig()
    if isinstance(model, Structure):
        effects = model.effects + effects
        model = linearise(replace(model, effects=()))
    displacement, velocity = _initial_states(model, displacement, velocity)
    steps = _steps(config.duration, config.sampling_rate, config.step)
    mass, damping, stiffness = model.mass.toarray(), full_damping(model), model.stiffness.toarray()
    if config.integrator == "rk67":
        _check_explicit(mass, stiffness, steps)
    joined = _effect_rows(model.dofs, effects)
    run = FreeMotion(mass, damping, stiffness, joined, steps, config.integrator)
    motions = []
    with _bar("free motion", len(displacement), progress) as bar:
        for x0, v0 in zip(displacement, velocity, strict=True):
            motions.append(run.run(x0, v0))
            bar.update()
    x, v = (np.stack(part) for part in zip(*motions, strict=True))  # each (realisation, time, free)
    force = v @ damping.T + x @ stiffness.T
    for effect, rows in joined:
        pull_back = effect.force(_elongation(x, rows), _elongation(v, rows))
        force[..., rows[-1]] += pull_back
        if len(rows) == 2:
            force[..., rows[0]] -= pull_back
    a = -np.linalg.solve(mass, force.reshape(-1, len(mass)).T).T.reshape(force.shape)
    displacements, velocities, accelerations = (_expand(model.dofs, part) for part in (x, v, a))
    return Response(_time(steps), displacements, velocities, accelerations, model.dofs)


def _steps(duration: float, sampling_rate: float, step: float) -> "Steps":
    """Return the grid of outputs, each interval split into the fewest equal steps of at most ``step``."""
    from fe_models.exudyn_solve import Steps

    values = {"duration": duration, "sampling_rate": sampling_rate, "step": step}
    raise_faults(f"{name} = {value}; must be positive" for name, value in values.items() if not 0 < value < np.inf)
    interval = 1 / sampling_rate
    outputs = round(duration * sampling_rate)
    if outputs < 1:
        raise InputError(f"duration = {duration} s is shorter than one sample at {sampling_rate} Hz")
    return Steps(interval, outputs, ceil(interval / step - 1e-9))


def _time(steps: "Steps") -> FloatArray:
    return np.linspace(0.0, steps.duration, steps.outputs + 1)


def _bar(what: str, total: int, progress: bool) -> Any:
    return tqdm(total=total, desc=what, disable=not progress, delay=BAR_DELAY)


def _modal_damping(tangent: LinearModel) -> FloatArray | None:
    """Return the damping matrix (dof, dof) of the modal ratios alone, None where there are none."""
    if not any(tangent.modal_ratios):
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


def _check_explicit(mass: FloatArray, stiffness: FloatArray, steps: "Steps") -> None:
    """Refuse what the explicit integrator cannot do: massless degrees of freedom, and steps too long for the modes."""
    try:
        highest = np.sqrt(eigh(stiffness, mass, eigvals_only=True, subset_by_index=[len(mass) - 1] * 2)[0])
    except np.linalg.LinAlgError:
        raise InputError("some degrees of freedom have no mass: choose the integrator newmark") from None
    step = steps.interval / steps.per_output
    if highest * step > RK67_REACH:
        raise InputError(
            f"a step of {step:.3g} s is too long for the highest mode ({highest / (2 * np.pi):.4g} Hz): "
            f"choose at most {RK67_REACH / highest:.2g} s, or the integrator newmark"
        )


def _effect_rows(
    dofs: DofMap, effects: tuple[ConnectorEffect, ...]
) -> tuple[tuple[ConnectorEffect, tuple[int, ...]], ...]:
    """Return each effect with the rows of its nodes among the free degrees of freedom."""
    place = np.cumsum(dofs.free) - 1
    joined, faults = [], []
    for effect in effects:
        rows = []
        for node in effect.nodes:
            try:
                row = dofs.row(node, effect.direction)
            except KeyError as missing:
                faults.append(f"{effect.kind}: {missing.args[0]}")
                continue
            if not dofs.free[row]:
                faults.append(f"{effect.kind}: node {node} is held in {effect.direction}; join a node that moves")
            rows.append(int(place[row]))
        joined.append((effect, tuple(rows)))
    raise_faults(faults)
    return tuple(joined)


def _elongation(values: FloatArray, rows: tuple[int, ...]) -> FloatArray:
    """Return u_last - u_first, or u of the only row, along the last axis of ``values``."""
    last = values[..., rows[-1]]
    return last - values[..., rows[0]] if len(rows) == 2 else last


def _expand(dofs: DofMap, free_values: FloatArray) -> FloatArray:
    """Return (..., free) as (..., dof) with zeros at the supports."""
    full = np.zeros((*free_values.shape[:-1], len(dofs)))
    full[..., dofs.free] = free_values
    return full
