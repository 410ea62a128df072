"""Blind cases: an effect hidden in simulated recordings of the chain, drawn from a seed; the truth is kept apart.

The truth is simulated in Exudyn in steps a fraction of those that a diagnosis takes and, where asked for, from a chain
that is off by what its user considers normal everywhere at once. Outside of the list of causes are `OUTSIDE`: a
hysteretic spring (Bouc and Wen) and a stiffness that drifts during each recording.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.sparse import csr_array

from fe_models.assembly import linearise
from fe_models.damping import full_damping
from fe_models.dofs import FloatArray
from fe_models.effects import (
    AddedMass,
    Cause,
    CoulombFriction,
    CubicSpring,
    Effect,
    ForceLaw,
    GapStop,
    HarmonicForce,
    ModalDamping,
    PointDamper,
    QuadraticDamper,
    SlackCable,
    StiffnessChange,
    SupportSpring,
)
from fe_models.errors import InputError
from fe_models.four_dof import four_dof
from fe_models.linear import LinearModel
from fe_models.recordings import Assumptions, Dataset, Recording, Sensor, Uncertainty
from fe_models.response import Response
from fe_models.sensor_effects import SensorDelay, SensorDrift, SensorEffect, SensorGain
from fe_models.simulate import FreeConfig, simulate_free
from fe_models.structure import Spring, Structure
from fe_models.time_integration import TimeIntegration

KINDS = (
    "stiffness_change",
    "added_mass",
    "support_spring",
    "modal_damping",
    "point_damper",
    "quadratic_damper",
    "coulomb_friction",
    "cubic_spring",
    "gap_stop",
    "slack_cable",
    "harmonic_force",
    "sensor_gain",
    "sensor_delay",
    "sensor_drift",
    "time_integration",
)
OUTSIDE = ("hysteretic_spring", "drifting_stiffness")
SENSORS = (
    Sensor("x4", 4, "x", "displacement", "m"),
    Sensor("a1", 1, "x", "acceleration", "m/s^2"),
    Sensor("a3", 3, "x", "acceleration", "m/s^2"),
    Sensor("a4", 4, "x", "acceleration", "m/s^2"),
    Sensor("a2", 2, "x", "acceleration", "m/s^2", "held_out"),
)
SIZES = {  # smallest and largest, relative to what stands beside it in `draw_cause`; drawn evenly in the logarithm
    "stiffness_change": (0.05, 0.6),
    "added_mass": (0.06, 0.8),
    "support_spring": (0.03, 1.0),
    "modal_damping": (1.5, 5.0),
    "point_damper": (0.03, 0.5),
    "quadratic_damper": (0.03, 0.5),
    "coulomb_friction": (0.02, 0.2),
    "cubic_spring": (0.03, 1.0),
    "gap_stop": (0.3, 5.0),
    "slack_cable": (0.2, 0.7),
    "harmonic_force": (0.03, 0.5),
    "sensor_gain": (0.03, 0.5),
    "sensor_delay": (0.02, 0.3),
    "sensor_drift": (0.1, 2.0),
    "time_integration": (0.05, 0.4),
    "hysteretic_spring": (0.2, 1.0),
    "drifting_stiffness": (0.2, 0.6),
}
FINE_STEP = 0.02  # s; of order 6, where the diagnosis takes 0.05 s at order 4
CREEP = 3e-3  # m/s, of the hidden friction


@dataclass(frozen=True)
class BlindConfig:
    """What a case is like: ``kinds`` to hide, ``off`` by its uncertainty or exact, ``noise`` over each channel's rms.

    ``size``: from 0, barely detectable, to 1, large; None draws it. ``changed``: number of training recordings made
    before the change, so that the effect is missing in them.
    """

    kinds: tuple[str, ...] = ()
    off: bool = False
    noise: float = 0.03
    size: float | None = None
    train: int = 9
    test: int = 3
    duration: float = 50.0
    sampling_rate: float = 10.0
    changed: int = 0


@dataclass(frozen=True)
class BlindCase:
    """A ``dataset`` and, apart, its ``truth``: the hidden causes, and the names of the recordings where they act.

    ``outside``: words of what was hidden that no cause of the list is. ``clean``: the test recordings without noise.
    """

    dataset: Dataset
    truth: tuple[Cause, ...]
    outside: tuple[str, ...]
    recordings: tuple[str, ...]
    clean: FloatArray


@dataclass(frozen=True)
class DriftingSpring(ForceLaw):
    """A spring to the ground or between two nodes whose stiffness grows in proportion to time: force = slope t u."""

    nodes: tuple[int, ...]
    slope: float  # N/(m s)
    timed = True

    @property
    def pulls(self) -> Any:
        """The last node with 1, the first of two with -1."""
        last = ((self.nodes[-1], "x", 1.0),)
        return last if len(self.nodes) == 1 else ((self.nodes[0], "x", -1.0), *last)

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return slope * t * u (N)."""
        return self.slope * t * u


def blind_case(seed: int, config: BlindConfig | None = None) -> BlindCase:
    """Return the case of a seed: everything random in it comes from there."""
    config = config or BlindConfig()
    unknown = [kind for kind in config.kinds if kind not in KINDS + OUTSIDE]
    if unknown:
        raise InputError(f"kinds {', '.join(unknown)} are unknown; expected {', '.join(KINDS + OUTSIDE)}")
    rng = np.random.default_rng(seed)
    design = four_dof()
    count = config.train + config.test
    state = rng.standard_normal((2, count, len(design.nodes)))  # m and m/s
    calm = _motion(design, (), state, config, (), rng)
    inside = [kind for kind in config.kinds if kind in KINDS]
    outside = tuple(kind for kind in config.kinds if kind in OUTSIDE)
    causes: list[Cause] = []
    for kind in inside:
        cause = draw_cause(kind, calm, rng, config.size)
        while any(cause.location == other.location and cause.kind == other.kind for other in causes):
            cause = draw_cause(kind, calm, rng, config.size)
        causes.append(cause)
    effects = tuple(cause for cause in causes if isinstance(cause, Effect))
    built = _off(design, rng) if config.off else design
    ratios = 1 + 0.1 * rng.standard_normal(len(design.nodes)) * config.off
    motion = _motion(built, effects, state, config, outside, rng, ratios)
    affected = np.arange(count) >= config.changed
    if config.changed:
        before = _motion(built, (), state, config, (), rng, ratios)
        parts = [np.where(affected[:, None, None], a, b) for a, b in zip(_parts(motion), _parts(before), strict=True)]
        motion = replace(motion, displacement=parts[0], velocity=parts[1], acceleration=parts[2])
    clean = np.stack([motion.channel(s.node, s.direction, s.quantity) for s in SENSORS], axis=-1)
    names = tuple(f"r{number:02d}" for number in range(1, count + 1))
    shown = clean
    for cause in causes:
        if isinstance(cause, SensorEffect):
            faulty = cause.apply(shown, [s.name for s in SENSORS], config.sampling_rate)
            shown = np.where(affected[:, None, None], faulty, shown)
    data = shown + config.noise * shown.std(axis=(0, 1)) * rng.standard_normal(shown.shape)
    recordings = tuple(
        Recording(name, data[i : i + 1], "train" if i < config.train else "test") for i, name in enumerate(names)
    )
    step = next((cause.step for cause in causes if isinstance(cause, TimeIntegration)), None)
    uncertainty = Uncertainty()
    assumptions = Assumptions(integrator="newmark" if step else "exact", step=step, uncertainty=uncertainty)
    dataset = Dataset(design, config.sampling_rate, SENSORS, recordings, assumptions=assumptions)
    acting = tuple(name for name, acts in zip(names, affected, strict=True) if acts)
    return BlindCase(dataset, tuple(causes), outside, acting, shown[config.train :])


def draw_cause(kind: str, calm: Response, rng: np.random.Generator, size: float | None) -> Cause:
    """Return a cause of that ``kind`` at a random place; ``calm``: the motion without it, which gives scales."""
    least, most = SIZES[kind]
    share = rng.uniform() if size is None else size
    amount = least * (most / least) ** share
    node, sign = int(rng.integers(1, 5)), float(rng.choice([-1.0, 1.0]))
    nodes: Any = (node,) if rng.uniform() < 0.6 or node == 1 else (node - 1, node)
    u = calm.channel(nodes[-1], "x", "displacement") - (
        calm.channel(nodes[0], "x", "displacement") if len(nodes) == 2 else 0.0
    )
    sensor = SENSORS[int(rng.integers(0, 4))]
    channel = calm.channel(sensor.node, "x", sensor.quantity)
    mass = {1: 1.0, 2: 2.0, 3: 3.0, 4: 4.0}[node]
    match kind:
        case "stiffness_change":
            return StiffnessChange((node,), 1 - amount if rng.uniform() < 0.7 else 1 + amount)
        case "added_mass":
            return AddedMass(node, amount * mass if rng.uniform() < 0.7 else -0.5 * amount * mass)
        case "support_spring":
            return SupportSpring(int(rng.integers(2, 5)), "x", amount)
        case "modal_damping":
            own = (0.070, 0.025, 0.016, 0.015)[node - 1]
            return ModalDamping((node,), amount * own)
        case "point_damper":
            return PointDamper(nodes, "x", amount)
        case "quadratic_damper":
            return QuadraticDamper(nodes, "x", amount)
        case "coulomb_friction":
            return CoulombFriction(nodes, "x", amount, CREEP)
        case "cubic_spring":
            softest = 0.1 / float(np.max(u**2))  # of the weakest spring: it must not turn over
            return CubicSpring(nodes, "x", amount if sign > 0 else -min(amount, softest))
        case "gap_stop":
            reach = float(np.quantile(sign * u, 0.999))
            return GapStop(nodes, "x", float(rng.uniform(0.3, 0.7)) * reach, amount, 1 if sign > 0 else -1)
        case "slack_cable":
            stretch = calm.channel(node, "x", "displacement")
            stretch = stretch - calm.channel(node - 1, "x", "displacement") if node > 1 else stretch
            stiffness = float(node)
            return SlackCable(node, stiffness * (1 - amount) * float(np.quantile(-stretch, 0.999)))
        case "harmonic_force":
            frequency = float(np.exp(rng.uniform(np.log(0.05), np.log(1.0))))
            return HarmonicForce(node, "x", amount, frequency, float(rng.uniform(0, 2 * np.pi)))
        case "sensor_gain":
            return SensorGain(sensor.name, 1 + sign * amount)
        case "sensor_delay":
            return SensorDelay(sensor.name, sign * amount)
        case "sensor_drift":
            return SensorDrift(sensor.name, sign * amount * float(channel.std() / calm.time[-1]))
        case "time_integration":
            return TimeIntegration(amount)
    raise InputError(f"kind {kind!r} cannot be drawn")


def _off(design: Structure, rng: np.random.Generator) -> Structure:
    """Return the design with every spring and mass off by 1 %."""
    elements = tuple(
        replace(e, stiffness=e.stiffness * (1 + 0.01 * rng.standard_normal()))
        for e in design.elements
        if isinstance(e, Spring)
    )
    masses = tuple(replace(m, mass=m.mass * (1 + 0.01 * rng.standard_normal())) for m in design.point_masses)
    return replace(design, elements=elements, point_masses=masses)


def _motion(
    built: Structure,
    effects: tuple[Effect, ...],
    state: FloatArray,
    config: BlindConfig,
    outside: tuple[str, ...],
    rng: np.random.Generator,
    ratios: FloatArray | None = None,
) -> Response:
    """Return the motion of ``built`` with ``effects``, and every damping ratio multiplied by ``ratios`` (mode,)."""
    linear_model = linearise(built.with_effects(*effects))
    if ratios is not None:
        linear_model = replace(linear_model, damping=linear_model.damping + _more_damping(built, ratios))
    laws: list[ForceLaw] = [law for effect in effects if (law := effect.law(built)) is not None]
    if "drifting_stiffness" in outside:
        element = int(rng.integers(1, 5))
        least, most = SIZES["drifting_stiffness"]
        change = rng.uniform(least, most) * rng.choice([-1, 1]) * element / config.duration
        laws.append(DriftingSpring((element,) if element == 1 else (element - 1, element), float(change)))
    if "hysteretic_spring" in outside:
        return _hysteretic(linear_model, state, config, rng)
    step = min(FINE_STEP, *(0.7 / max(law.largest_slopes[1], 1e-9) for law in laws)) if laws else FINE_STEP
    run = FreeConfig(config.duration, config.sampling_rate, step)
    return simulate_free(linear_model, state[0], state[1], run, tuple(laws), progress=False)


def _more_damping(built: Structure, ratios: FloatArray) -> csr_array:
    """Return what multiplying each mode's damping ratio adds to C, of the structure without what is hidden in it."""
    model = linearise(built)
    mass, own = model.mass.toarray(), full_damping(model)
    _, shapes = eigh(model.stiffness.toarray(), mass)
    weighted = mass @ shapes
    return csr_array((weighted * (np.einsum("di,de,ei->i", shapes, own, shapes) * (ratios - 1))) @ weighted.T)


def _hysteretic(model: LinearModel, state: FloatArray, config: BlindConfig, rng: np.random.Generator) -> Response:
    """Return the motion with a Bouc-Wen spring k z, z' = v - (|v| |z| z / 2 + v z^2 / 2) / d^2, at a random node."""
    least, most = SIZES["hysteretic_spring"]
    node, k = int(rng.integers(0, 4)), float(rng.uniform(least, most))
    d = float(rng.uniform(0.2, 0.5))  # m, where the spring yields
    M, C, K = model.mass.toarray(), model.damping.toarray(), model.stiffness.toarray()
    count, n = state.shape[1:]
    time = np.arange(round(config.duration * config.sampling_rate) + 1) / config.sampling_rate
    pull = np.eye(n)[node]

    def rates(_t: float, y: FloatArray) -> FloatArray:
        x, v, z = np.split(y.reshape(2 * n + 1, count), [n, 2 * n])
        a = -np.linalg.solve(M, C @ v + K @ x + np.outer(pull, k * z[0]))
        w = v[node]
        dz = w - 0.5 * (np.abs(w) * np.abs(z[0]) * z[0] + w * z[0] ** 2) / d**2
        return np.concatenate([v, a, dz[None]]).ravel()

    start = np.concatenate([state[0].T, state[1].T, np.zeros((1, count))]).ravel()
    done = solve_ivp(rates, (0, time[-1]), start, t_eval=time, rtol=1e-8, atol=1e-9, method="DOP853")
    y = done.y.reshape(2 * n + 1, count, len(time)).transpose(1, 2, 0)  # (recording, time, state)
    x, v, z = y[..., :n], y[..., n : 2 * n], y[..., 2 * n]
    a = -np.linalg.solve(M, (x @ K.T + v @ C.T + k * z[..., None] * pull).reshape(-1, n).T).T.reshape(x.shape)
    return Response(time, x, v, a, model.dofs)


def _parts(motion: Response) -> tuple[FloatArray, FloatArray, FloatArray]:
    return motion.displacement, motion.velocity, motion.acceleration
