"""Blind cases of the bridge: the truth against closed forms, the same from the same seed, and every kind is felt."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from benchmarks.blind_cases import BRIDGE_KINDS, OUTSIDE, BlindCase, BlindConfig, blind_case, save_case
from benchmarks.blind_cases.bridge_draw import draw_cause
from benchmarks.blind_cases.bridge_scene import Scene, free_motion
from benchmarks.blind_cases.bridge_truth import OUTPUT_RATE, Start, Truth, modal_state, motion_at, off_by_uncertainty
from benchmarks.blind_cases.marching import Grid, integrate_motion
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import (
    ConnectorEffect,
    CoulombFriction,
    CubicSpring,
    GapStop,
    HarmonicForce,
    HystereticSpring,
    PointDamper,
    QuadraticDamper,
    SensorGain,
    TimeIntegration,
)
from fe_models.causes.time_integration import root
from fe_models.errors import InputError
from fe_models.files.bridge_recordings import bridge_sensors
from fe_models.files.dataset_file import load_dataset
from fe_models.files.recording_checks import check_data
from fe_models.modes import natural_modes
from fe_models.nominal import nominal_modes
from fe_models.simulation import FreeConfig, simulate_free
from fe_models.structure import Beam, Cable, Damping
from hybrid.diagnosis.discrepancy.hysteresis import Hysteresis

SHORT = BlindConfig(structure="bridge", rich=False, train=1, test=1, duration=3.0)
SENSORS = bridge_sensors("A2", "m/s^2")


def recordings(case: BlindCase) -> FloatArray:
    return np.concatenate([recording.data for recording in case.dataset.recordings])


def left_by_nominal(case: BlindCase) -> FloatArray:
    """Return what no initial state of the nominal modes explains, over each channel's rms: (recording, sensor)."""
    dataset = case.dataset
    modes = nominal_modes(dataset, 10)
    step = TimeIntegration(dataset.assumptions.step) if dataset.assumptions.step else None
    pole = root(modes.omega, modes.damping_ratio)
    shown = step.shown_root(pole) if step else pole
    rows = [modes.dofs.row(sensor.node, str(sensor.direction)) for sensor in dataset.sensors]
    data = recordings(case)
    time = np.arange(data.shape[1]) / dataset.sampling_rate
    motion = np.exp(np.multiply.outer(time, shown))[:, None] * (modes.shapes[rows] * pole**2)  # (time, sensor, mode)
    size = data.std(axis=(0, 1))
    basis = np.concatenate([motion.real, motion.imag], axis=-1) / size[:, None]
    basis = basis.reshape(-1, basis.shape[-1])
    values = (data / size).reshape(len(data), -1).T
    left = values - basis @ np.linalg.lstsq(basis, values, rcond=None)[0]
    return np.sqrt(np.mean(left.T.reshape(data.shape) ** 2, axis=1))


def test_nothing_hidden_is_the_nominal_model_and_noise() -> None:
    clean = blind_case(1, replace(SHORT, noise=0.0))
    # The low-pass leaves each mode's decay as it is, but for the ends of its filter, which the margin keeps away.
    assert left_by_nominal(clean).max() < 1e-3
    noisy = left_by_nominal(blind_case(1, SHORT))
    np.testing.assert_allclose(noisy, 0.03, rtol=0.15)  # 301 samples, of which the low-pass leaves 180 independent


def test_the_contract_of_a_laboratory_recording() -> None:
    dataset = blind_case(2, SHORT).dataset
    assert (dataset.sampling_rate, dataset.lowpass) == (100.0, 30.0)
    assert [sensor.name for sensor in dataset.sensors if sensor.role == "held_out"] == ["A2"]
    assert {sensor.unit for sensor in dataset.sensors} == {"m/s^2"}
    assert dataset.model == bridge()
    for recording in dataset.recordings:
        assert recording.data.shape == (1, 301, 8)
        assert check_data(recording.data, [s.name for s in SENSORS], 100.0, 30.0) == []
    campaign = BlindConfig(structure="bridge").campaign
    assert (campaign.train, campaign.test, campaign.samples) == (3, 1, 2000)


def test_same_seed_same_case_other_seed_another() -> None:
    config = replace(SHORT, kinds=("cubic_spring",), tier="off", duration=1.0)
    first, again, other = (blind_case(seed, config) for seed in (3, 3, 4))
    np.testing.assert_array_equal(recordings(first), recordings(again))
    assert first.truth == again.truth
    assert first.truth != other.truth
    assert np.abs(recordings(first) - recordings(other)).max() > 0.1 * np.abs(recordings(first)).max()


@pytest.mark.parametrize("kind", BRIDGE_KINDS + OUTSIDE)
def test_every_kind_is_felt(kind: str) -> None:
    case = blind_case(5, replace(SHORT, kinds=(kind,), size=1.0, test=0, duration=2.0))
    assert [cause.kind for cause in case.truth] + list(case.outside) == [kind]
    # Noise alone is 0.03, to 7 % from as many independent samples as the low-pass leaves of 200.
    assert left_by_nominal(case).max() > 1.4 * 0.03


def test_effects_come_with_the_change() -> None:
    config = replace(SHORT, kinds=("added_mass",), size=1.0, train=2, changed=1)
    case = blind_case(6, config)
    assert case.recordings == ("r02", "r03")
    left = left_by_nominal(case).max(axis=1)  # (recording,)
    assert left[0] < 0.04
    assert left[1:].min() > 0.06


def test_two_effects_at_once() -> None:
    case = blind_case(7, replace(SHORT, kinds=("added_mass", "modal_damping")))
    assert [cause.kind for cause in case.truth] == ["added_mass", "modal_damping"]


def test_marching_is_exact_for_a_linear_motion_and_of_order_two_beside_it() -> None:
    modal = natural_modes(linearise(bridge().without_prestress()), 20)
    q, p = np.linspace(1, 2, 20)[:, None] / modal.omega[:, None] ** 2, np.zeros((20, 1))
    row = modal.dofs.row(15, "y")
    end = integrate_motion(modal, (q, p), Grid(0.0, 0.5, 1, 1), [row])[0, -1, 0, 0]  # in one step
    pole = root(modal.omega, modal.damping_ratio)
    exact = modal.shapes[row] @ (q[:, 0] * (np.exp(0.5 * pole) * (1 + 1j * pole.real / pole.imag)).real)
    assert end == pytest.approx(exact, rel=1e-9)
    laws = (CubicSpring((15,), "y", 3e6),)  # as stiff as a tenth of the bridge there
    values = [integrate_motion(modal, (q, p), Grid(0.0, 0.5, 1, n), [row], laws)[0, -1, 0, 0] for n in (200, 400, 800)]
    assert abs(values[0] - end) > 1e-3 * abs(end)
    order = np.log2(abs(values[0] - values[1]) / abs(values[1] - values[2]))
    assert 1.7 < order < 2.3


@pytest.mark.parametrize(
    "law",
    [
        CubicSpring((1,), "x", 0.5),
        QuadraticDamper((3, 4), "x", 0.3),
        CoulombFriction((2,), "x", 0.1, 1e-2),
        GapStop((4,), "x", 0.5, 2.0, -1),
        HarmonicForce(2, "x", 0.3, 0.4, 1.0),
    ],
    ids=lambda law: law.kind,
)
def test_marching_agrees_with_exudyn_on_force_laws(law: ConnectorEffect | HarmonicForce) -> None:
    chain = replace(four_dof(), dashpots=(), damping=Damping(mass_factor=0.05))
    start = np.random.default_rng(0).standard_normal((2, 4))
    free = simulate_free(chain, start[:1], start[1:], FreeConfig(20.0, 10.0, 0.005), (law,), progress=False)
    linear = linearise(chain)
    modal = natural_modes(linear, 4)
    q, p = (modal.shapes.T @ (linear.mass @ part)[:, None] for part in start)
    motion = integrate_motion(modal, (q, p), Grid(0.0, 0.1, 200, 20), [0, 1, 2, 3], (law,))[..., 0]
    for ours, theirs in zip(motion, (free.displacement, free.velocity, free.acceleration), strict=True):
        # Of order 2 in steps of 5 ms, where friction and stop turn within a few of them.
        np.testing.assert_allclose(ours, theirs[0], rtol=0, atol=2e-3 * np.abs(theirs).max())


def test_damping_that_couples_modes_is_that_of_the_state_space() -> None:
    design = bridge().without_prestress().with_effects(PointDamper((12,), "y", 5.0))
    linear = linearise(design)
    M, C, K = (part.toarray() for part in (linear.mass, linear.damping, linear.stiffness))
    starts = (Start(((15, 3.0),), np.zeros(0)),)
    shown = motion_at(Truth(design, np.ones(0), rich=False), starts, SENSORS, 1.0, 0.0)[0]
    load = np.zeros(len(linear.dofs))
    load[linear.dofs.row(15, "y")] = -3.0
    size = len(M)
    step = expm(
        0.1 * np.block([[np.zeros((size, size)), np.eye(size)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    )
    state = np.concatenate([np.linalg.solve(K, load[linear.dofs.free]), np.zeros(size)])
    for _ in range(5):
        state = step @ state
    acceleration = np.zeros(len(linear.dofs))
    acceleration[linear.dofs.free] = -np.linalg.solve(M, K @ state[:size] + C @ state[size:])
    rows = [linear.dofs.row(s.node, str(s.direction)) for s in SENSORS]
    np.testing.assert_allclose(shown[250], acceleration[rows], rtol=0, atol=5e-3 * np.abs(acceleration[rows]).max())


def test_rich_truth_tends_to_the_linear_one_for_small_motions() -> None:
    design = replace(bridge().without_prestress(), divisions=2)
    left = []
    for weight in (30.0, 3.0):  # 20 mm and 2 mm at mid-span
        starts = (Start(((15, weight),), np.zeros(0)),)
        plain, rich = (
            motion_at(Truth(design, np.ones(0), r), starts, SENSORS, 0.5, 0.0, (), 30.0) for r in (False, True)
        )
        left.append(float(np.abs(rich - plain).max() / np.abs(plain).max()))
    assert left[0] > 5 * left[1]  # by symmetry the error is of order 2 in the amplitude at least in mid-span
    assert 0 < left[1] < 0.05


def test_a_bridge_in_time_steps_is_that_of_exudyns_newmark() -> None:
    """Measured in the second half: 6e-4 of the largest displacement, of how Exudyn begins; without the steps 3e-2."""
    design, step = bridge().without_prestress(), 2e-3
    starts = (Start(((9, 3.0),), np.zeros(0)),)  # at rest: a rate is another amplitude there
    linear = linearise(design)
    modal = natural_modes(linear, 10)
    q, p = modal_state(modal, starts[0], 30.0)
    x, v = (modal.shapes[modal.dofs.free] @ part for part in (q, p))
    config = FreeConfig(2.0, OUTPUT_RATE, step, "newmark")
    motion = simulate_free(design, x[None], v[None], config, progress=False)
    sensors = tuple(replace(sensor, quantity="displacement", unit="m") for sensor in SENSORS)
    theirs = np.stack([motion.shown(s)[0] for s in sensors], axis=-1)
    errors = []
    for own in (step, None):
        ours = motion_at(Truth(design, np.ones(0), False, own), starts, sensors, 2.0, 0.0, (), 30.0)[0]
        errors.append(np.abs(ours - theirs)[500:].max() / np.abs(theirs).max())
    assert errors[0] < 1e-3 < 1e-2 < errors[1]


def test_off_by_its_uncertainty_as_wholes() -> None:
    design = bridge()
    off = off_by_uncertainty(design, np.random.default_rng(0))
    pairs = list(zip(design.elements, off.elements, strict=True))
    assert all(isinstance(a, Beam | Cable) and isinstance(b, Beam | Cable) for a, b in pairs)
    stiffness = [b.section.axial_stiffness / a.section.axial_stiffness for a, b in pairs]  # type: ignore[union-attr]
    for group in (slice(0, 28), slice(28, 40), slice(40, 52)):
        np.testing.assert_allclose(stiffness[group], stiffness[group][0])
    assert len({round(value, 9) for value in stiffness}) == 3 + 8
    many = [off_by_uncertainty(design, np.random.default_rng(seed)).point_masses[10].mass / 0.5 for seed in range(60)]
    assert np.std(many) == pytest.approx(0.01, rel=0.3)  # of 60 draws


def test_a_saved_case_is_read_back_and_its_truth_lies_apart(tmp_path: Path) -> None:
    case = blind_case(8, replace(SHORT, kinds=("slack_cable",), duration=1.0))
    path = save_case(case, tmp_path / "case")
    loaded = load_dataset(path)
    assert loaded.model == bridge()
    np.testing.assert_array_equal(loaded.recordings[1].data, case.dataset.recordings[1].data)
    assert "slack" not in path.read_text()
    truth = json.loads((path.parent / "truth.json").read_text())
    assert truth["causes"][0]["kind"] == "slack_cable"
    assert truth["causes"][0]["parameters"] == case.truth[0].parameters
    assert truth["recordings"] == ["r01", "r02"]


@pytest.mark.parametrize("config", [replace(SHORT, measured=2), BlindConfig(train=2, test=1, measured=2)])
@pytest.mark.parametrize("seed", range(3))
def test_a_hidden_fault_is_in_one_of_the_sensors_that_there_are(config: BlindConfig, seed: int) -> None:
    case = blind_case(seed, replace(config, kinds=("sensor_gain",)))
    (fault,) = case.truth
    sensors = case.dataset.sensors
    assert isinstance(fault, SensorGain)
    assert [sensor.role for sensor in sensors].count("measured") == 2
    assert fault.sensor in [sensor.name for sensor in sensors if sensor.role == "measured"]
    assert len([sensor for sensor in sensors if sensor.role == "held_out"]) == 1
    assert all(recording.data.shape[-1] == 3 for recording in case.dataset.recordings)


def test_unknown_wishes_are_refused() -> None:
    with pytest.raises(InputError, match="kinds rust are unknown"):
        blind_case(0, replace(SHORT, kinds=("rust",)))
    with pytest.raises(InputError, match="kinds axial_force are unknown"):
        blind_case(0, BlindConfig(("axial_force",)))
    with pytest.raises(InputError, match="changed = 3; expected 0 to 1"):
        blind_case(0, replace(SHORT, changed=3))
    with pytest.raises(InputError, match="measured = 5; expected 1 to 4, the sensors of four_dof"):
        blind_case(0, BlindConfig(measured=5))
    with pytest.raises(InputError, match="expected a divisor of 500 Hz"):
        blind_case(0, replace(SHORT, sampling_rate=130.0))


@pytest.mark.slow
def test_hysteretic_spring_yields_in_the_motion_that_it_leaves() -> None:
    """One that does not is a plain spring, which is on the list."""
    design = bridge().without_prestress()
    model = linearise(design)
    modal = natural_modes(model, 10)
    rng = np.random.default_rng(2)
    q, p = 0.5 * rng.standard_normal((2, 10, 4)) / modal.omega[:, None] ** np.array([2, 1])[:, None, None]
    scene = Scene(design, model, modal, free_motion(modal, q, p, np.arange(500) / 100), SENSORS)
    for _ in range(10):
        spring = draw_cause("hysteretic_spring", scene, rng, 1.0)
        assert isinstance(spring, HystereticSpring)
        node, direction = spring.nodes[0], spring.direction
        own = scene.local_stiffness(node, direction)
        left = own / (own + spring.stiffness)
        u, v = (left * scene.calm.channel(node, direction, kind) for kind in ("displacement", "velocity"))
        z = np.stack([Hysteresis(spring).along(motion).z for motion in u])
        u, v, z = (part - part.mean(axis=1, keepdims=True) for part in (u, v, z))
        follows = np.linalg.lstsq(np.stack([u.ravel(), v.ravel()], axis=1), z.ravel(), rcond=None)[0]
        rest = z - follows[0] * u - follows[1] * v
        assert rest.std() > 0.2 * z.std()  # no spring and dashpot do as much; 1e-5 where it never yields
