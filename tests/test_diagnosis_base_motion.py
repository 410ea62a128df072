"""Structures whose base moves: against a closed form and an independent solver, and what a diagnosis makes of them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise, unsupported
from fe_models.base_motion import BaseMotion
from fe_models.causes import AddedMass, CubicSpring
from fe_models.causes.places import Motion
from fe_models.damping import full_damping
from fe_models.recordings import Dataset, Quantity, Recording, Sensor
from fe_models.structure import Damping, PointMass, Spring, Structure
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.batches import batches_of
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from tests.sample_dataset import MAST

RATE, SAMPLES = 100.0, 401
TIME = np.arange(SAMPLES) / RATE
QUANTITIES: tuple[Quantity, ...] = ("displacement", "velocity", "acceleration")


def cart(stiffness: float = 400.0, mass: float = 2.0, ratio: float = 0.05) -> Structure:
    return Structure(
        name="cart",
        nodes=((0.0, 0.0),),
        directions=("x",),
        elements=(Spring((1,), "x", stiffness),),
        point_masses=(PointMass(1, mass),),
        damping=Damping(modal_ratios=(ratio,)),
    )


def every_sensor(node: int, direction: str = "x") -> tuple[Sensor, ...]:
    return tuple(
        Sensor(f"{quantity} {reference}", node, direction, quantity, "1", reference=reference)  # type: ignore[arg-type]
        for reference in ("base", "absolute")
        for quantity in QUANTITIES
    )


def shaken(structure: Structure, sensors: tuple[Sensor, ...], *base: BaseMotion) -> FloatArray:
    """Return what the response used in a diagnosis shows from rest, (time, sensor)."""
    samples = len(base[0].values)
    recording = Recording("r", np.zeros((1, samples, len(sensors))), base=base)
    dataset = Dataset(structure, RATE, sensors, (recording,))
    hypothesis = Hypothesis(nominal_model_of(dataset))
    outputs = SensorOutputs.faultless(sensors, RATE)
    system = system_of(hypothesis, np.zeros((1, hypothesis.nuisances)), outputs)
    (batch,) = batches_of(dataset, "train")
    return respond(system, np.zeros((1, 1, hypothesis.states)), samples, batch.loads)[0, 0]


def test_one_mass_on_a_base_that_moves_as_a_sine_has_the_closed_form() -> None:
    """From rest, u'' + 2 xi w u' + w^2 u = -A sin(W t): transient and steady state (Chopra, Dynamics of Structures)."""
    w, xi, A, W = np.sqrt(400.0 / 2.0), 0.05, 3.0, 9.0
    wd = w * np.sqrt(1 - xi**2)
    D = (w**2 - W**2) ** 2 + (2 * xi * w * W) ** 2
    c, d = -A * (w**2 - W**2) / D, A * 2 * xi * w * W / D  # of sin and cos
    a, b = -d, (-c * W - xi * w * d) / wd
    decay = np.exp(-xi * w * TIME)
    u = decay * (a * np.cos(wd * TIME) + b * np.sin(wd * TIME)) + c * np.sin(W * TIME) + d * np.cos(W * TIME)
    v = (
        decay * ((b * wd - xi * w * a) * np.cos(wd * TIME) - (a * wd + xi * w * b) * np.sin(wd * TIME))
        + c * W * np.cos(W * TIME)
        - d * W * np.sin(W * TIME)
    )
    ground = np.stack(
        [A / W * TIME - A / W**2 * np.sin(W * TIME), A / W * (1 - np.cos(W * TIME)), A * np.sin(W * TIME)]
    )
    relative = np.stack([u, v, -ground[2] - 2 * xi * w * v - w**2 * u])
    expected = np.concatenate([relative, relative + ground]).T
    found = shaken(cart(), every_sensor(1), BaseMotion("x", ground[2]))
    # (W h)^8 / 1.2e6 = 1e-14 is what a spline of degree seven loses between samples; ends and rounding more.
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())


def solved(structure: Structure, base: dict[str, FloatArray], cubic: float = 0.0, node: int = 3) -> FloatArray:
    """Return the relative motion (3, time, dof) by another solver, from matrices of the whole structure."""
    linear = linearise(structure)
    free = linear.dofs.free_rows
    mass = unsupported(structure)[0].toarray()
    r = {axis: (linear.dofs.direction == axis).astype(float) for axis in base}
    curve = {axis: make_interp_spline(TIME, values, 7) for axis, values in base.items()}
    M, C, K = mass[np.ix_(free, free)], full_damping(linear), linear.stiffness.toarray()
    inertia = {axis: -(mass @ shape)[free] for axis, shape in r.items()}
    at = int(np.flatnonzero(free == linear.dofs.row(node, "x"))[0])
    inverse, n = np.linalg.inv(M), len(free)

    def accelerated(t: float, z: FloatArray) -> FloatArray:
        force = sum(inertia[axis] * curve[axis](t) for axis in base) - K @ z[:n] - C @ z[n:]
        force[at] -= cubic * z[at] ** 3
        return inverse @ force

    run = solve_ivp(
        lambda t, z: np.concatenate([z[n:], accelerated(t, z)]),
        (0, TIME[-1]),
        np.zeros(2 * n),
        t_eval=TIME,
        rtol=1e-10,
        atol=1e-12,
        method="Radau" if n > 3 else "DOP853",
    )
    motion = np.zeros((3, len(TIME), len(linear.dofs)))
    motion[0][:, free], motion[1][:, free] = run.y[:n].T, run.y[n:].T
    motion[2][:, free] = [accelerated(t, z) for t, z in zip(run.t, run.y.T, strict=True)]
    return motion


def quake(seed: int, size: float = 3.0, highest: float = 12.0) -> FloatArray:
    """Return an acceleration (time,), m/s^2, of sines up to the ``highest`` frequency (Hz), random in phase."""
    rng = np.random.default_rng(seed)
    waves = highest * (np.arange(20) + rng.uniform(0.1, 0.9, 20)) / 20
    return size / 4 * np.sin(2 * np.pi * np.outer(TIME, waves) + rng.uniform(0, 2 * np.pi, 20)).sum(axis=1)


TOWER = replace(MAST, damping=Damping(0.5, 1e-4), name="tower")


@pytest.mark.slow
def test_a_frame_whose_supports_carry_part_of_a_consistent_mass_moves_as_in_another_solver() -> None:
    base = {"x": quake(1), "y": quake(2)}
    motion = solved(TOWER, base)
    dofs = linearise(TOWER).dofs
    sensors = (*every_sensor(2)[:3], *every_sensor(3)[:3], replace(every_sensor(3, "y")[5], name="up"))
    found = shaken(TOWER, sensors, *(BaseMotion(axis, values) for axis, values in base.items()))  # type: ignore[arg-type]
    rows = [dofs.row(2, "x")] * 3 + [dofs.row(3, "x")] * 3
    expected = np.column_stack([motion[i % 3][:, row] for i, row in enumerate(rows)])
    up = motion[2][:, dofs.row(3, "y")] + base["y"]
    scale = np.abs(expected).max(axis=0)
    # The modes beyond half the sampling rate give way by a series of three terms, good for 1e-3 of what they take part.
    assert np.max(np.abs(found[:, :6] - expected)[20:-20] / scale) < 1e-3
    assert np.abs(found[:, 6] - up)[20:-20].max() < 2e-3 * np.abs(up).max()


def test_an_oblique_motion_is_the_sum_of_its_parts() -> None:
    sensors = every_sensor(3)[3:]
    values = quake(3)
    parts = BaseMotion("x", 0.6 * values), BaseMotion("y", 0.8 * values)
    along = shaken(TOWER, sensors, BaseMotion((3.0, 4.0), values))
    np.testing.assert_allclose(along, shaken(TOWER, sensors, *parts), atol=1e-9 * np.abs(along).max())
    turned = shaken(TOWER, sensors, BaseMotion(float(np.degrees(np.arctan2(4, 3))), values))
    np.testing.assert_allclose(along, turned, atol=1e-9 * np.abs(along).max())


STOREYS = Structure(
    name="storeys",
    nodes=tuple((0.0, float(level)) for level in (1, 2, 3)),
    directions=("x",),
    elements=(Spring((1,), "x", 3e4), Spring((1, 2), "x", 3e4), Spring((2, 3), "x", 3e4)),
    point_masses=tuple(PointMass(node, 25.0) for node in (1, 2, 3)),
    damping=Damping(modal_ratios=(0.02,)),
)


def test_a_cubic_spring_under_strong_motion_moves_as_in_another_solver() -> None:
    stiffness, values = 2e7, quake(4, highest=8.0)
    motion = solved(STOREYS, {"x": values}, cubic=stiffness, node=1)
    plain = solved(STOREYS, {"x": values}, node=1)
    assert np.abs(motion - plain)[0].max() > 0.1 * np.abs(motion[0]).max()  # the law is felt
    sensors = (*every_sensor(1)[:3], *every_sensor(3)[3:])
    law = STOREYS.with_effects(CubicSpring((1,), "x", stiffness))
    found = shaken(law, sensors, BaseMotion("x", values))
    u, v, a = motion
    expected = np.column_stack([u[:, 0], v[:, 0], a[:, 0]])
    scale = np.abs(expected).max(axis=0)
    # Substeps are as long as forces allow: 1e-4 of the motion.
    assert np.max(np.abs(found[:, :3] - expected) / scale) < 1e-4
    absolute = a[:, 2] + values
    assert np.abs(found[:, 5] - absolute).max() < 1e-4 * np.abs(absolute).max()


def test_a_mass_that_is_added_is_carried_along_by_the_base() -> None:
    values = quake(5)
    sensors = every_sensor(3)
    heavier = STOREYS.with_effects(AddedMass(2, 5.0))
    truth = shaken(heavier, sensors, BaseMotion("x", values))
    recording = Recording("r", np.zeros((1, SAMPLES, len(sensors))), base=(BaseMotion("x", values),))
    nominal = nominal_model_of(Dataset(STOREYS, RATE, sensors, (recording,)))
    motion = Motion(*np.random.default_rng(0).standard_normal((2, 50, 3)))
    dataset = Dataset(STOREYS, RATE, sensors, (recording,))
    found = all_candidates(nominal, dataset, motion, tuple(range(len(sensors))))
    (mass,) = [c for c in found if c.kind == "added_mass" and c.location == {"node": 2}]
    hypothesis = Hypothesis(nominal, (mass,))
    theta = np.append(np.zeros(hypothesis.nuisances), 5.0)[None]
    system = system_of(hypothesis, theta, SensorOutputs.faultless(sensors, RATE))
    (batch,) = batches_of(dataset, "train")
    shown = respond(system, np.zeros((1, 1, hypothesis.states)), SAMPLES, batch.loads)[0, 0]
    np.testing.assert_allclose(shown, truth, atol=1e-6 * np.abs(truth).max())
