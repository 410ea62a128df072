"""What is hidden in the bridge: kind by kind a random place, and a size from barely detectable to large."""

from typing import Any

import numpy as np

from benchmarks.blind_cases.bridge_scene import FELT_MODES, Scene
from benchmarks.blind_cases.drawing import amount_between, recording_cause, slack_cable
from benchmarks.blind_cases.outside import CreepingSpring, DriftingSpring, SwingingSpring
from fe_models.built_in.bridge import ROLLERS
from fe_models.causes import (
    AddedMass,
    AxialForce,
    Cause,
    CoulombFriction,
    CubicSpring,
    ForceLaw,
    GapStop,
    HarmonicForce,
    HystereticSpring,
    ModalDamping,
    PointDamper,
    QuadraticDamper,
    SlackCable,
    StiffnessChange,
    SupportSpring,
)
from fe_models.errors import InputError
from fe_models.structure import Beam

DECK, TOWERS, CABLES = range(1, 30), (*range(31, 43), *range(44, 56)), range(53, 61)
SPAN = tuple(node for node in DECK if node not in ROLLERS)
MAX_DRAWS = 200

SIZES = {  # smallest and largest; drawn evenly in the logarithm
    "stiffness_change": (0.003, 0.06),  # of these five: relative shift of the frequency that is shifted most
    "added_mass": (0.003, 0.06),
    "support_spring": (0.003, 0.1),
    "axial_force": (0.003, 0.06),
    "cubic_spring": (0.003, 0.06),  # by the spring that does as much work at the rms of the motion
    "modal_damping": (1.5, 6.0),  # times its own ratio, which is 0.3 % in the first modes
    "point_damper": (0.0007, 0.02),  # of these three: damping ratio added to the mode that is damped most
    "quadratic_damper": (0.0007, 0.02),
    "coulomb_friction": (0.0007, 0.01),
    "gap_stop": (0.03, 1.0),  # of the stiffness that the place itself has
    "slack_cable": (0.2, 0.7),  # of the largest compression: how much of it the cable does not take
    "harmonic_force": (0.05, 1.0),  # rms of what it makes the sensor show that feels it most, over the calm rms
    "sensor_gain": (0.03, 0.5),
    "sensor_delay": (5e-4, 1e-2),  # s
    "sensor_drift": (0.1, 2.0),  # of the channel's rms, by the end of the recording
    "time_integration": (2e-3, 1.2e-2),  # s: shifts 11 Hz by 0.2 % to 6 %
    "hysteretic_spring": (0.01, 0.1),  # frequency shift, where it does not yield
    "drifting_stiffness": (0.2, 0.6),  # of a cable's stiffness, from start to end
    "swinging_stiffness": (0.2, 0.6),  # of a cable's stiffness, up and down
    "creeping_spring": (0.01, 0.1),  # frequency shift, where it does not creep
}
SWINGS = (0.1, 1.0)  # Hz, of a stiffness: slower than any mode, which none is driven by then
SHARPNESS = (1.0, 6.0)
CREEPS = (0.5, 2.0)  # of a radian of the motion: how long a spring lasts that is stretched by its reach
FORCING = (1.0, 12.0)  # Hz
CREEP_SHARE = 0.01  # of the rms velocity at its place: below it, the hidden friction is a dashpot
MAX_LOSS, MAX_GAIN, MAX_LOAD = 0.95, 1.0, 5.0  # at most: of an element's stiffness, likewise, and kg


def draw_cause(kind: str, scene: Scene, rng: np.random.Generator, size: float | None) -> Cause:
    """Return a cause of that ``kind`` where it can be felt; ``size`` from 0 to 1, None draws it."""
    for _ in range(MAX_DRAWS):
        cause = _drawn(kind, amount_between(*SIZES[kind], rng, size), scene, rng)
        if cause is not None:
            return cause
    raise InputError(f"no place found where {kind} is felt")


def draw_outside(kind: str, scene: Scene, rng: np.random.Generator, size: float | None, duration: float) -> ForceLaw:
    """Return a force that is no cause of the list, in recordings of that ``duration`` (s)."""
    amount = amount_between(*SIZES[kind], rng, size)
    if kind in ("drifting_stiffness", "swinging_stiffness"):
        law = SlackCable(int(rng.choice(CABLES)), 0.0).law(scene.design)
        assert law is not None  # the drawn cables have their stiffness
        change = float(rng.choice([-1, 1]) * amount * law.stiffness)
        if kind == "drifting_stiffness":
            return DriftingSpring(law.pulls, change / duration)
        return SwingingSpring(law.pulls, change, float(np.exp(rng.uniform(*np.log(SWINGS)))))
    found = None
    while found is None:
        node = int(rng.choice(SPAN))
        found = _yielding(node, "y", amount, scene, rng)
    stiffness, reach = found
    moved, rate = scene.rms(node, "y")
    return CreepingSpring(((node, "y", 1.0),), stiffness, reach, float(rng.uniform(*CREEPS)) * moved / rate)


def _yielding(
    node: int, direction: Any, amount: float, scene: Scene, rng: np.random.Generator
) -> tuple[float, float] | None:
    """Return the stiffness of a spring that shifts frequencies by an ``amount``, and a reach (m) that it exceeds.

    None where it is stiffer than the place itself: it would hold it as a support does, and never yield.
    """
    stiffness, own = scene.spring(node, direction, amount), scene.local_stiffness(node, direction)
    if stiffness is None or stiffness > own:
        return None
    moving = scene.rms(node, direction)[0] * own / (own + stiffness)  # m: about what the spring leaves of the motion
    return stiffness, float(rng.uniform(0.5, 1.5)) * moving


def _drawn(kind: str, amount: float, scene: Scene, rng: np.random.Generator) -> Cause | None:
    """Return a cause of that size, or None where the place that was drawn is not good for it."""
    sensor = scene.sensors[int(rng.choice([i for i, s in enumerate(scene.sensors) if s.role == "measured"]))]
    sign = float(rng.choice([-1.0, 1.0]))
    match kind:
        case "stiffness_change" | "added_mass" | "axial_force" | "support_spring":
            return _linear(kind, amount, scene, rng)
        case "modal_damping":
            mode = int(rng.integers(1, FELT_MODES + 1))
            return ModalDamping((mode,), amount * float(scene.modal.damping_ratio[mode - 1]))
        case "slack_cable":
            return slack_cable(int(rng.choice(CABLES)), amount, scene.design, scene.calm)
    found = recording_cause(kind, amount, sign, sensor, scene.calm)
    return _at_a_node(kind, amount, scene, rng) if found is None else found


def _linear(kind: str, amount: float, scene: Scene, rng: np.random.Generator) -> Cause | None:
    usually = rng.uniform() < 0.7
    match kind:
        case "stiffness_change":
            element = int(rng.integers(1, len(scene.design.elements) + 1))
            size = scene.amount(
                StiffnessChange((element,), 0.0 if usually else 2.0), amount, MAX_LOSS if usually else MAX_GAIN
            )
            return None if size is None else StiffnessChange((element,), 1 - size if usually else 1 + size)
        case "added_mass":
            node = int(rng.choice((*SPAN, *TOWERS)))  # at a roller it is felt in the sway alone, at all rollers alike
            own = sum(point.mass for point in scene.design.point_masses if point.node == node)
            size = scene.amount(AddedMass(node, 1.0 if usually else -1.0), amount, MAX_LOAD if usually else 0.9 * own)
            return None if size is None else AddedMass(node, size if usually else -size)
        case "axial_force":
            group = str(rng.choice(["deck", "left tower", "right tower"]))
            elements = enumerate(scene.design.elements, start=1)
            numbers = tuple(i for i, element in elements if isinstance(element, Beam) and element.group == group)
            size = scene.amount(AxialForce(numbers, -1.0 if usually else 1.0), amount, 1e4)
            return None if size is None else AxialForce(numbers, -size if usually else size)
    if rng.uniform() < 0.5:
        node = int(rng.choice(ROLLERS))
        soft = scene.support(node, "y", amount)
        return None if soft is None else SupportSpring(node, "y", soft)
    node, direction = _place(rng)
    stiffness = scene.spring(node, direction, amount) if scene.moves(node, direction) else None
    return None if stiffness is None else SupportSpring(node, direction, stiffness)


def _at_a_node(kind: str, amount: float, scene: Scene, rng: np.random.Generator) -> Cause | None:
    node, direction = _place(rng)
    sign = float(rng.choice([-1.0, 1.0]))
    if not scene.moves(node, direction):
        return None
    u, v = scene.rms(node, direction)
    match kind:
        case "point_damper":
            return PointDamper((node,), direction, scene.damper(node, direction, amount))
        case "quadratic_damper":  # of a normally distributed v, E(|v| v^2) / E(v^2) = sqrt(8 / pi) rms
            equal = float(np.sqrt(8 / np.pi)) * v
            return QuadraticDamper((node,), direction, scene.damper(node, direction, amount) / equal)
        case "coulomb_friction":  # E(|v|) / E(v^2) = sqrt(2 / pi) / rms
            equal = float(np.sqrt(2 / np.pi)) / v
            return CoulombFriction((node,), direction, scene.damper(node, direction, amount) / equal, CREEP_SHARE * v)
        case "cubic_spring":  # E(u^4) / E(u^2) = 3 rms^2
            linear = scene.spring(node, direction, amount)
            if linear is None:
                return None
            largest = float(np.abs(scene.calm.channel(node, direction, "displacement")).max())
            softest = 0.1 * scene.local_stiffness(node, direction) / largest**2  # it must not turn over
            stiffness = linear / (3 * u**2)
            return CubicSpring((node,), direction, stiffness if sign > 0 else -min(stiffness, softest))
        case "hysteretic_spring":
            found = _yielding(node, direction, amount, scene, rng)
            if found is None:
                return None
            stiffness, reach = found
            sharpness = float(np.exp(rng.uniform(*np.log(SHARPNESS))))
            return HystereticSpring((node,), direction, stiffness, stiffness * reach, sharpness)
        case "gap_stop":
            moved = sign * scene.calm.channel(node, direction, "displacement")
            gap = float(rng.uniform(0.3, 0.7) * np.quantile(moved, 0.999))
            stiffness = amount * scene.local_stiffness(node, direction)
            return GapStop((node,), direction, gap, stiffness, 1 if sign > 0 else -1)
        case "harmonic_force":
            frequency = float(np.exp(rng.uniform(*np.log(FORCING))))
            force = amount / scene.steady(node, direction, frequency)
            return HarmonicForce(node, direction, force, frequency, float(rng.uniform(0, 2 * np.pi)))
    raise InputError(f"kind {kind!r} cannot be drawn")


def _place(rng: np.random.Generator) -> tuple[int, Any]:
    """Return a deck node that moves in y, or a tower's, in x: where something can be fixed."""
    return (int(rng.choice(SPAN)), "y") if rng.uniform() < 0.6 else (int(rng.choice(TOWERS)), "x")
