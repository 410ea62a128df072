"""Blind cases of the chain: what is hidden where and how large, and its simulation in Exudyn.

In steps a fraction of those that a diagnosis takes and, where asked for, of a chain that is off by what its user
considers normal everywhere at once, or by far more.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import eigh
from scipy.sparse import csr_array

from benchmarks.blind_cases.case import BlindCase, BlindConfig, as_recorded, sensors_of
from benchmarks.blind_cases.drawing import amount_between, causes_apart, recording_cause, slack_cable
from benchmarks.blind_cases.far import far_from
from benchmarks.blind_cases.outside import DriftingSpring, HystereticSpring
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import (
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
    StiffnessChange,
    SupportSpring,
)
from fe_models.damping import full_damping
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.recordings import Sensor
from fe_models.response import Response
from fe_models.simulation import FreeConfig, simulate_free
from fe_models.structure import Spring, Structure

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
CREEP_RATE = 3e-3  # m/s, of the hidden friction
# kg: largest dashpot that a law is at rest, times the step; masses of 1 kg and 2 kg move it together
MAX_DASHPOT_STEP = 0.5


def chain_case(seed: int, config: BlindConfig) -> BlindCase:
    """Return the case of a seed: everything random in it comes from there."""
    rng = np.random.default_rng(seed)
    design, sensors = four_dof(), sensors_of(SENSORS, config, rng)
    state = rng.standard_normal((2, config.campaign.count, len(design.nodes)))  # m and m/s
    far = far_from(design, rng) if config.tier == "far" else None
    built, ratios = (far.structure, far.ratios) if far else (design, None)
    calm = _motion(built, (), state, config, (), rng, ratios)
    causes = causes_apart(config.hidden, lambda kind: draw_cause(kind, calm, rng, config.size, sensors))
    effects = tuple(cause for cause in causes if isinstance(cause, Effect))
    if far is None:
        built = _off(design, rng) if config.tier == "off" else design
        ratios = 1 + 0.1 * rng.standard_normal(len(design.nodes)) * (config.tier == "off")
    motion = _motion(built, effects, state, config, config.outside, rng, ratios)
    if not config.affected.all():
        lasting = tuple(effect for effect in effects if effect in config.lasting(causes))
        before = _motion(built, lasting, state, config, (), rng, ratios)
        acts = config.affected[:, None, None]
        parts = [np.where(acts, a, b) for a, b in zip(_parts(motion), _parts(before), strict=True)]
        motion = replace(motion, displacement=parts[0], velocity=parts[1], acceleration=parts[2])
    clean = np.stack([motion.channel(s.node, s.direction, s.quantity) for s in sensors], axis=-1)
    case = as_recorded(design, sensors, clean, tuple(causes), config, rng)
    return replace(case, factors=far.factors if far else ())


def draw_cause(
    kind: str, calm: Response, rng: np.random.Generator, size: float | None, sensors: tuple[Sensor, ...] = SENSORS
) -> Cause:
    """Return a cause of that ``kind`` at a random place; ``calm``: the motion without it, which gives scales."""
    amount = amount_between(*SIZES[kind], rng, size)
    node, sign = int(rng.integers(1, 5)), float(rng.choice([-1.0, 1.0]))
    nodes: Any = (node,) if rng.uniform() < 0.6 or node == 1 else (node - 1, node)
    u = calm.channel(nodes[-1], "x", "displacement") - (
        calm.channel(nodes[0], "x", "displacement") if len(nodes) == 2 else 0.0
    )
    measured = [sensor for sensor in sensors if sensor.role == "measured"]
    sensor = measured[int(rng.integers(0, len(measured)))]
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
            return CoulombFriction(nodes, "x", amount, CREEP_RATE)
        case "cubic_spring":
            softest = 0.1 / float(np.max(u**2))  # of the weakest spring: it must not turn over
            return CubicSpring(nodes, "x", amount if sign > 0 else -min(amount, softest))
        case "gap_stop":
            reach = float(np.quantile(sign * u, 0.999))
            return GapStop(nodes, "x", float(rng.uniform(0.3, 0.7)) * reach, amount, 1 if sign > 0 else -1)
        case "slack_cable":
            return slack_cable(node, amount, four_dof(), calm)
        case "harmonic_force":
            frequency = float(np.exp(rng.uniform(np.log(0.05), np.log(1.0))))
            return HarmonicForce(node, "x", amount, frequency, float(rng.uniform(0, 2 * np.pi)))
    found = recording_cause(kind, amount, sign, sensor, calm)
    if found is None:
        raise InputError(f"kind {kind!r} cannot be drawn")
    return found


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
        change = rng.uniform(least, most) * rng.choice([-1, 1]) * element / config.campaign.duration
        last: tuple[tuple[int, Any, float], ...] = ((element, "x", 1.0),)
        laws.append(DriftingSpring(last if element == 1 else ((element - 1, "x", -1.0), *last), float(change)))
    if "hysteretic_spring" in outside:
        return _hysteretic(linear_model, state, config, rng)
    step = min(FINE_STEP, *(MAX_DASHPOT_STEP / max(law.largest_slopes[1], 1e-9) for law in laws)) if laws else FINE_STEP
    run = FreeConfig(config.campaign.duration, config.campaign.sampling_rate, step)
    return simulate_free(linear_model, state[0], state[1], run, tuple(laws), progress=False)


def _more_damping(built: Structure, ratios: FloatArray) -> csr_array:
    """Return what multiplying each mode's damping ratio adds to C, of the structure without what is hidden in it."""
    model = linearise(built)
    mass, own = model.mass.toarray(), full_damping(model)
    _, shapes = eigh(model.stiffness.toarray(), mass)
    weighted = mass @ shapes
    return csr_array((weighted * (np.einsum("di,de,ei->i", shapes, own, shapes) * (ratios - 1))) @ weighted.T)


def _hysteretic(model: LinearModel, state: FloatArray, config: BlindConfig, rng: np.random.Generator) -> Response:
    """Return the motion with a hysteretic spring between a random node and the ground."""
    least, most = SIZES["hysteretic_spring"]
    node, k = int(rng.integers(0, 4)), float(rng.uniform(least, most))
    spring = HystereticSpring(((node + 1, "x", 1.0),), k, reach=float(rng.uniform(0.2, 0.5)))
    M, C, K = model.mass.toarray(), model.damping.toarray(), model.stiffness.toarray()
    count, n = state.shape[1:]
    time = np.arange(config.campaign.samples) / config.campaign.sampling_rate
    pull = np.eye(n)[node]

    def rates(_t: float, y: FloatArray) -> FloatArray:
        x, v, z = np.split(y.reshape(2 * n + 1, count), [n, 2 * n])
        a = -np.linalg.solve(M, C @ v + K @ x + np.outer(pull, k * z[0]))
        return np.concatenate([v, a, spring.rate(v[node], z[0])[None]]).ravel()

    start = np.concatenate([state[0].T, state[1].T, np.zeros((1, count))]).ravel()
    done = solve_ivp(rates, (0, time[-1]), start, t_eval=time, rtol=1e-8, atol=1e-9, method="DOP853")
    y = done.y.reshape(2 * n + 1, count, len(time)).transpose(1, 2, 0)  # (recording, time, state)
    x, v, z = y[..., :n], y[..., n : 2 * n], y[..., 2 * n]
    a = -np.linalg.solve(M, (x @ K.T + v @ C.T + k * z[..., None] * pull).reshape(-1, n).T).T.reshape(x.shape)
    return Response(time, x, v, a, model.dofs)


def _parts(motion: Response) -> tuple[FloatArray, FloatArray, FloatArray]:
    return motion.displacement, motion.velocity, motion.acceleration
