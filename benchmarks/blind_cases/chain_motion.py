"""The motion of a chain in a blind case: free, from rest under known forces or on a moving base, or under unknown ones.

Free motion is Exudyn's, in steps a fraction of those that a diagnosis takes; all else is marched in modal coordinates,
exact for what is linear.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.sparse import csr_array

from benchmarks.blind_cases.ambient import UnknownForces, ambient_motion
from benchmarks.blind_cases.case import BlindConfig
from benchmarks.blind_cases.known_forces import SIZE, Driving
from benchmarks.blind_cases.marching import Grid, damping_coupling, integrate_motion
from benchmarks.blind_cases.outside import CreepingSpring, DriftingSpring, SwingingSpring
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.causes import Effect, ForceLaw, LawWithMemory, MemorylessLaw
from fe_models.damping import full_damping
from fe_models.drive import drive_of, ground_motion
from fe_models.linear import LinearModel
from fe_models.modes import natural_modes
from fe_models.recordings import QUANTITIES, Sensor
from fe_models.response import Response
from fe_models.simulation import FreeConfig, simulate_free
from fe_models.structure import Structure

OUTSIDE_SIZES = {
    "drifting_stiffness": (0.2, 0.6),  # of a spring's stiffness, from start to end
    "swinging_stiffness": (0.2, 0.6),  # of a spring's stiffness, up and down
    "creeping_spring": (0.2, 1.0),  # N/m
}
SWINGS = (0.01, 0.03)  # Hz: below twice the lowest natural frequency, 0.039 Hz, where motion would grow without end
REACHES, CREEPS = (0.2, 0.5), (0.5, 2.0)  # m, and s: how long a spring lasts that is stretched by its reach
FINE_STEP = 0.02  # s; of order 6, where the diagnosis takes 0.05 s at order 4
# kg: largest dashpot that a law is at rest, times the step; masses of 1 kg and 2 kg move it together
MAX_DASHPOT_STEP = 0.5
SMOOTH_STEPS, STEPS = 10, 20  # of a sample, of order 2: without force laws and with them
AMBIENT_STEPS = 4  # of a sample, so that what is folded down from above half the sampling rate hardly shows


@dataclass(frozen=True)
class Moved:
    """What moves each recording: its initial ``state`` (2, recording, node), in m and m/s, what is known to drive it
    from rest, ``driving``, or what is not, ``unknown``.
    """

    state: FloatArray
    driving: tuple[Driving, ...] = ()
    unknown: tuple[UnknownForces, ...] = ()


@dataclass(frozen=True)
class Chain:
    """A chain as it is in a recording: ``built``, with ``effects`` in it and every damping ratio multiplied by
    ``ratios`` (mode,); ``outside``: words of what no cause of the list is.
    """

    built: Structure
    effects: tuple[Effect, ...] = ()
    ratios: FloatArray | None = None
    outside: tuple[str, ...] = ()

    @property
    def structure(self) -> Structure:
        """With its effects."""
        return self.built.with_effects(*self.effects)

    @property
    def linear(self) -> LinearModel:
        """Its linear model."""
        model = linearise(self.structure)
        if self.ratios is None:
            return model
        return replace(model, damping=model.damping + _more_damping(self.built, self.ratios))


def motion_of(chain: Chain, moved: Moved, config: BlindConfig, rng: np.random.Generator) -> Response:
    """Return the motion (recording, time, dof) of a chain, in whose ``config`` ``outside`` stand for themselves."""
    model = chain.linear
    laws: list[ForceLaw] = [law for effect in chain.effects if (law := effect.law(chain.built)) is not None]
    if "drifting_stiffness" in chain.outside:
        laws.append(_drifting_spring(config, rng))
    if "swinging_stiffness" in chain.outside:
        laws.append(_swinging_spring(rng))
    if "creeping_spring" in chain.outside:
        laws.append(_creeping_spring(rng))
    if moved.unknown:
        return _ambient(model, moved.unknown, config)
    if moved.driving:
        return driven(chain.structure, model, moved.driving, config, tuple(laws))
    if any(isinstance(law, LawWithMemory) for law in laws):
        return _remembering(model, moved.state, config, laws)
    step = min(FINE_STEP, *(MAX_DASHPOT_STEP / max(law.largest_slopes[1], 1e-9) for law in laws)) if laws else FINE_STEP
    run = FreeConfig(config.campaign.duration, config.campaign.sampling_rate, step)
    return simulate_free(model, moved.state[0], moved.state[1], run, tuple(laws), progress=False)


def scaled(chain: Chain, driving: tuple[Driving, ...], config: BlindConfig) -> tuple[Driving, ...]:
    """Return what drives a chain so strong that the linear one moves by `SIZE` in each recording."""
    moved = driven(chain.structure, chain.linear, driving, config).displacement
    sizes = np.sqrt(np.mean(moved**2, axis=(1, 2)))
    return tuple(item.times(SIZE / float(size)) for item, size in zip(driving, sizes, strict=True))


def shown(motion: Response, sensor: Sensor, driving: tuple[Driving, ...], sampling_rate: float) -> FloatArray:
    """Return what a sensor without fault shows, (recording, time): on a moving base the absolute motion, too."""
    relative = motion.shown(sensor)
    if sensor.reference == "base" or not driving:
        return relative
    bases = [item.recorded(sampling_rate).base for item in driving]
    ground = np.stack([ground_motion(base, sampling_rate, motion.time) for base in bases])  # (recording, 3, time, 3)
    return np.asarray(relative + ground[:, QUANTITIES.index(sensor.quantity), :, 0])


def driven(
    structure: Structure,
    model: LinearModel,
    driving: tuple[Driving, ...],
    config: BlindConfig,
    laws: tuple[ForceLaw, ...] = (),
) -> Response:
    """Return the motion (recording, time, dof) from rest under known forces, or relative to a base that moves."""
    campaign, modal = config.campaign, natural_modes(model, model.mass.shape[0])
    grid = Grid(0.0, 1 / campaign.sampling_rate, campaign.samples - 1, STEPS if laws else SMOOTH_STEPS)
    steps = grid.outputs * grid.per_output + 1  # one beyond the last output
    time = np.linspace(0.0, steps * grid.step, steps + 1)
    drives = [
        drive_of(structure, item.recorded(campaign.sampling_rate).all, campaign.sampling_rate) for item in driving
    ]
    known = np.stack([drive.at(time) @ modal.shapes for drive in drives], axis=-1)  # (step, mode, recording)
    rest, coupling = np.zeros((len(modal.omega), len(driving))), damping_coupling(model, modal)
    rows = list(range(len(modal.dofs)))
    u, v, a = integrate_motion(modal, (rest, rest), grid, rows, laws, lambda q, p: -coupling @ p, known).transpose(
        0, 3, 1, 2
    )
    return Response(time[:: grid.per_output][: campaign.samples], u, v, a, modal.dofs)


def _ambient(model: LinearModel, unknown: tuple[UnknownForces, ...], config: BlindConfig) -> Response:
    campaign, modal = config.campaign, natural_modes(model, model.mass.shape[0])
    every = [
        Sensor(f"{quantity} {node}", int(node), direction, quantity, "1")
        for quantity in QUANTITIES
        for node, direction in zip(modal.dofs.node, modal.dofs.direction.tolist(), strict=True)
    ]
    rate = AMBIENT_STEPS * campaign.sampling_rate
    found = [ambient_motion(model, modal, forces, tuple(every), campaign.duration, rate) for forces in unknown]
    parts = np.split(np.stack(found)[:, ::AMBIENT_STEPS], len(QUANTITIES), axis=-1)
    time = np.arange(campaign.samples) / campaign.sampling_rate
    return Response(time, parts[0], parts[1], parts[2], modal.dofs)


def _drifting_spring(config: BlindConfig, rng: np.random.Generator) -> DriftingSpring:
    along, change = _changing(OUTSIDE_SIZES["drifting_stiffness"], rng)
    return DriftingSpring(along, change / config.campaign.duration)


def _swinging_spring(rng: np.random.Generator) -> SwingingSpring:
    along, change = _changing(OUTSIDE_SIZES["swinging_stiffness"], rng)
    return SwingingSpring(along, change, float(rng.uniform(*SWINGS)))


def _changing(sizes: tuple[float, float], rng: np.random.Generator) -> tuple[tuple[tuple[int, Any, float], ...], float]:
    """Return what a random spring of the chain is stretched by, and a change of its stiffness (N/m)."""
    element = int(rng.integers(1, 5))
    change = rng.uniform(*sizes) * rng.choice([-1, 1]) * element
    last: tuple[tuple[int, Any, float], ...] = ((element, "x", 1.0),)
    return (last if element == 1 else ((element - 1, "x", -1.0), *last)), float(change)


def _creeping_spring(rng: np.random.Generator) -> CreepingSpring:
    """Return a spring that creeps between a random node and the ground."""
    node, stiffness = int(rng.integers(1, 5)), float(rng.uniform(*OUTSIDE_SIZES["creeping_spring"]))
    return CreepingSpring(((node, "x", 1.0),), stiffness, float(rng.uniform(*REACHES)), float(rng.uniform(*CREEPS)))


def _more_damping(built: Structure, ratios: FloatArray) -> csr_array:
    """Return what multiplying each mode's damping ratio adds to C, of the structure without what is hidden in it."""
    model = linearise(built)
    mass, own = model.mass.toarray(), full_damping(model)
    _, shapes = eigh(model.stiffness.toarray(), mass)
    weighted = mass @ shapes
    return csr_array((weighted * (np.einsum("di,de,ei->i", shapes, own, shapes) * (ratios - 1))) @ weighted.T)


def _remembering(model: LinearModel, state: FloatArray, config: BlindConfig, laws: Sequence[ForceLaw]) -> Response:
    """Return free motion from a ``state`` (2, recording, node) under laws some of which have a memory."""
    M, C, K = model.mass.toarray(), model.damping.toarray(), model.stiffness.toarray()
    (count, n), free = state.shape[1:], model.dofs.free
    time = np.arange(config.campaign.samples) / config.campaign.sampling_rate
    every = [(law, model.dofs.pull(law.pulls)[free]) for law in laws]
    direct = [(law, pull) for law, pull in every if isinstance(law, MemorylessLaw)]
    remembering = [(law, pull) for law, pull in every if isinstance(law, LawWithMemory)]

    def accelerations(t: Any, x: FloatArray, v: FloatArray, z: FloatArray) -> FloatArray:  # (node or law, motion) each
        total = C @ v + K @ x
        for law, pull in direct:
            total = total + np.outer(pull, law.force(pull @ x, pull @ v, t))
        for (own, pull), remembered in zip(remembering, z, strict=True):
            total = total + np.outer(pull, own.force_of(remembered))
        return -np.linalg.solve(M, total)

    def rates(t: float, y: FloatArray) -> FloatArray:
        x, v, z = np.split(y.reshape(-1, count), [n, 2 * n])
        moved = [law.rate(pull @ v, own) for (law, pull), own in zip(remembering, z, strict=True)]
        return np.concatenate([v, accelerations(t, x, v, z), moved]).ravel()

    begun = [law.pulled_to(pull @ state[0].T) for law, pull in remembering]
    start = np.concatenate([state[0].T, state[1].T, begun]).ravel()
    done = solve_ivp(rates, (0, time[-1]), start, t_eval=time, rtol=1e-8, atol=1e-9, method="DOP853")
    whole = done.y.reshape(2 * n + len(remembering), -1)
    x, v, z = np.split(whole, [n, 2 * n])  # (node or law, recording and time)
    a = accelerations(np.tile(time, count), x, v, z)
    found = [part.reshape(n, count, len(time)).transpose(1, 2, 0) for part in (x, v, a)]
    return Response(time, found[0], found[1], found[2], model.dofs)
