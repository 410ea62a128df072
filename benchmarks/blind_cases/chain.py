"""Blind cases of the chain: what moves it, what is hidden where and how large.

Where asked for, of a chain that is off by what its user considers normal everywhere at once, or by far more.
"""

from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.blind_cases.ambient import UnknownForces
from benchmarks.blind_cases.case import BlindCase, BlindConfig, as_recorded, sensors_of
from benchmarks.blind_cases.chain_motion import Chain, Moved, motion_of, scaled, shown
from benchmarks.blind_cases.drawing import amount_between, causes_apart, recording_cause, slack_cable
from benchmarks.blind_cases.far import far_from
from benchmarks.blind_cases.known_forces import drawn_driving, loads_of
from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import (
    AddedMass,
    Cause,
    CoulombFriction,
    CubicSpring,
    Effect,
    GapStop,
    HarmonicForce,
    HystereticSpring,
    LoadDelay,
    LoadGain,
    ModalDamping,
    PointDamper,
    QuadraticDamper,
    QuadraticSpring,
    StiffnessChange,
    SupportSpring,
)
from fe_models.errors import InputError
from fe_models.recordings import Sensor
from fe_models.response import Response
from fe_models.structure import Spring, Structure

SENSORS = (
    Sensor("x4", 4, "x", "displacement", "m"),
    Sensor("a1", 1, "x", "acceleration", "m/s^2"),
    Sensor("a3", 3, "x", "acceleration", "m/s^2"),
    Sensor("a4", 4, "x", "acceleration", "m/s^2"),
    Sensor("a2", 2, "x", "acceleration", "m/s^2", "held_out"),
)
# On a moving base nobody measures a displacement from elsewhere.
ON_A_BASE = tuple(replace(s, reference="base") if s.quantity == "displacement" else s for s in SENSORS)
SIZES = {  # smallest and largest, relative to what stands beside it in `draw_cause`; drawn evenly in the logarithm
    "stiffness_change": (0.05, 0.6),
    "added_mass": (0.06, 0.8),
    "support_spring": (0.03, 1.0),
    "modal_damping": (1.5, 5.0),
    "point_damper": (0.03, 0.5),
    "quadratic_damper": (0.03, 0.5),
    "coulomb_friction": (0.02, 0.2),
    "cubic_spring": (0.03, 1.0),
    "quadratic_spring": (0.03, 0.5),
    "gap_stop": (0.3, 5.0),
    "hysteretic_spring": (0.2, 1.0),  # N/m, while motion is small
    "slack_cable": (0.2, 0.7),
    "harmonic_force": (0.03, 0.5),
    "sensor_gain": (0.03, 0.5),
    "sensor_delay": (0.02, 0.3),
    "sensor_drift": (0.1, 2.0),
    "time_integration": (0.05, 0.4),
    "load_gain": (0.03, 0.5),  # as of sensors
    "load_delay": (0.02, 0.3),
}
REACHES = (0.2, 0.5)  # of the rms elongation: where a hysteretic spring slides
SHARPNESS = (1.0, 6.0)
CREEP_RATE = 3e-3  # m/s, of the hidden friction
CORNERS = (0.5, 2.0)  # Hz: up to where unknown forces are white; the modes end at 0.34 Hz


def chain_case(seed: int, config: BlindConfig) -> BlindCase:
    """Return the case of a seed: everything random in it comes from there."""
    rng = np.random.default_rng(seed)
    design, sensors = four_dof(), sensors_of(ON_A_BASE if config.excitation == "base" else SENSORS, config, rng)
    moved = _moved(design, config, rng)
    far = far_from(design, rng) if config.tier == "far" else None
    drawn = Chain(far.structure, ratios=far.ratios) if far else Chain(design)
    moved = replace(moved, driving=scaled(drawn, moved.driving, config)) if moved.driving else moved
    calm = motion_of(drawn, moved, config, rng)
    causes = causes_apart(
        config.hidden, lambda kind: draw_cause(kind, calm, rng, config.size, sensors, loads_of(moved.driving))
    )
    effects = tuple(cause for cause in causes if isinstance(cause, Effect))
    if far is None:
        built = _off(design, rng) if config.tier == "off" else design
        ratios = 1 + 0.1 * rng.standard_normal(len(design.nodes)) * (config.tier == "off")
        drawn = Chain(built, ratios=ratios)
    motion = motion_of(replace(drawn, effects=effects, outside=config.outside), moved, config, rng)
    if not config.affected.all():
        lasting = tuple(effect for effect in effects if effect in config.lasting(causes))
        before = motion_of(replace(drawn, effects=lasting), moved, config, rng)
        acts = config.affected[:, None, None]
        parts = [np.where(acts, a, b) for a, b in zip(_parts(motion), _parts(before), strict=True)]
        motion = replace(motion, displacement=parts[0], velocity=parts[1], acceleration=parts[2])
    rate = config.campaign.sampling_rate
    clean = np.stack([shown(motion, sensor, moved.driving, rate) for sensor in sensors], axis=-1)
    driving = [
        item.recorded(rate, causes if acts else config.lasting(causes))
        for item, acts in zip(moved.driving, config.affected, strict=bool(moved.driving))
    ]
    known = [(item.loads, item.base) for item in driving]
    case = as_recorded(design, sensors, clean, tuple(causes), config, rng, driving=known)
    return replace(case, factors=far.factors if far else ())


def _moved(design: Structure, config: BlindConfig, rng: np.random.Generator) -> Moved:
    """Return what moves each recording."""
    count, nodes = config.campaign.count, len(design.nodes)
    if config.excitation == "free":
        return Moved(rng.standard_normal((2, count, nodes)))
    rest = np.zeros((2, count, nodes))
    if config.excitation != "ambient":
        return Moved(rest, drawn_driving(config, nodes, rng))
    places = tuple((node, design.directions[0]) for node in range(1, nodes + 1))
    drawn = [(float(rng.uniform(*CORNERS)), int(rng.integers(2**32))) for _ in range(count)]
    return Moved(rest, unknown=tuple(UnknownForces(places, np.ones(nodes), corner, seed) for corner, seed in drawn))


def draw_cause(
    kind: str,
    calm: Response,
    rng: np.random.Generator,
    size: float | None,
    sensors: tuple[Sensor, ...] = SENSORS,
    loads: tuple[int, ...] = (),
) -> Cause:
    """Return a cause of that ``kind`` at a random place; ``calm``: the motion without it, which gives scales.

    ``loads``: the nodes at which forces were recorded.
    """
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
        case "quadratic_spring":
            softest = 0.25 / float(np.max(np.abs(u)))  # N/m^2: of the weakest spring it leaves half
            return QuadraticSpring(nodes, "x", sign * min(amount, softest))
        case "gap_stop":
            reach = float(np.quantile(sign * u, 0.999))
            return GapStop(nodes, "x", float(rng.uniform(0.3, 0.7)) * reach, amount, 1 if sign > 0 else -1)
        case "hysteretic_spring":
            reach = float(rng.uniform(*REACHES) * np.std(u))
            sharpness = float(np.exp(rng.uniform(*np.log(SHARPNESS))))
            return HystereticSpring(nodes, "x", amount, amount * reach, sharpness)
        case "slack_cable":
            return slack_cable(node, amount, four_dof(), calm)
        case "harmonic_force":
            frequency = float(np.exp(rng.uniform(np.log(0.05), np.log(1.0))))
            return HarmonicForce(node, "x", amount, frequency, float(rng.uniform(0, 2 * np.pi)))
        case "load_gain":
            return LoadGain((int(rng.choice(loads)), "x"), 1 + sign * amount)
        case "load_delay":
            return LoadDelay((int(rng.choice(loads)), "x"), sign * amount)
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


def _parts(motion: Response) -> tuple[FloatArray, FloatArray, FloatArray]:
    return motion.displacement, motion.velocity, motion.acceleration
