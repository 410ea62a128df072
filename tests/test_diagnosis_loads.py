"""Recordings under known loads: their motion against other solvers, and what a diagnosis makes of them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from fe_models.assembly import linearise
from fe_models.blind import SENSORS
from fe_models.blind.bridge import SENSORS as BRIDGE_SENSORS
from fe_models.blind.marching import Grid
from fe_models.blind.marching import march as modal_march
from fe_models.bridge import bridge
from fe_models.dofs import FloatArray
from fe_models.effects import CubicSpring, Effect, ForceLaw, HarmonicForce, StiffnessChange
from fe_models.four_dof import four_dof
from fe_models.measurement import lowpassed
from fe_models.modes import natural_modes
from fe_models.recordings import Assumptions, Dataset, Load, Recording
from fe_models.simulate import FreeConfig, simulate_free
from hybrid.diagnosis.candidates import all_candidates
from hybrid.diagnosis.driven import motion_of
from hybrid.diagnosis.hypothesis import Hypothesis
from hybrid.diagnosis.loaded import loaded_states
from hybrid.diagnosis.marching import respond
from hybrid.diagnosis.places import Motion
from hybrid.diagnosis.plant import plant_of
from hybrid.diagnosis.records import batches_of
from hybrid.diagnosis.system import System

RATE, SAMPLES = 10.0, 301
FITTED = tuple(sensor for sensor in SENSORS if sensor.role == "measured")
EVERY = tuple(range(len(FITTED)))
Waves = tuple[HarmonicForce, ...]  # of which known loads are made, so that other solvers know them as effects


def waves(seed: int, node: int = 2, size: float = 0.3, highest: float = 0.6, count: int = 8) -> Waves:
    """Return harmonic forces (N) between zero and the ``highest`` frequency (Hz), random in phase."""
    rng = np.random.default_rng(seed)
    frequencies = highest * (np.arange(count) + rng.uniform(0.1, 0.9, count)) / count
    return tuple(HarmonicForce(node, "x", size, float(f), float(rng.uniform(0, 2 * np.pi))) for f in frequencies)


def load_of(forces: Waves, samples: int = SAMPLES, rate: float = RATE) -> Load:
    time = np.arange(samples) / rate
    return Load(forces[0].node, forces[0].direction, np.sum([-wave.force(0, 0, time) for wave in forces], axis=0))


def chain_motion(forces: Waves, start: FloatArray, *effects: Effect) -> FloatArray:
    """Return what Exudyn shows (time, sensor) from a ``start`` (2, dof): displacement and velocity."""
    config = FreeConfig((SAMPLES - 1) / RATE, RATE, 0.01)
    structure = four_dof().with_effects(*effects, *forces)
    motion = simulate_free(structure, start[:1], start[1:], config, progress=False)
    return np.stack([motion.channel(s.node, s.direction, s.quantity)[0] for s in SENSORS], axis=-1)


def chain_dataset(*parts: Recording) -> Dataset:
    return Dataset(four_dof(), RATE, SENSORS, parts)


def nominal(dataset: Dataset, *laws: Effect) -> System:
    plant = plant_of(replace(dataset, model=four_dof().with_effects(*laws)))
    hypothesis = Hypothesis(plant)
    return hypothesis.system(np.zeros((1, hypothesis.nuisances)), FITTED, RATE, EVERY)


START = np.random.default_rng(0).standard_normal((2, 4))
NOTHING = np.zeros((1, SAMPLES, len(SENSORS)))


@pytest.mark.parametrize("laws", [(), (CubicSpring((1,), "x", 0.5),)], ids=["linear", "cubic"])
def test_chain_under_a_load_moves_as_in_exudyn(laws: tuple[Effect, ...]) -> None:
    forces = waves(1)
    truth = chain_motion(forces, START, *laws)[:, :4]
    dataset = chain_dataset(Recording("r", truth[None], loads=(load_of(forces),)))
    (batch,) = batches_of(dataset, "train")
    system = nominal(dataset, *laws)
    states = START.reshape(1, 1, -1)
    error, without = (
        np.abs(respond(system, states, SAMPLES, loads)[0, 0] - truth).max() for loads in (batch.loads, None)
    )
    assert without > 0.5 * np.abs(truth).max()  # the load is felt
    # A spline through samples of a force at 0.6 Hz is off by some (omega h)^4 / 720 = 3e-5, of which eight waves have
    # most below; straight lines would be off by 1e-2, and Exudyn's and the law's own steps by 1e-6.
    assert error < 3e-5 * np.abs(truth).max()


def test_segments_continue_each_other() -> None:
    dataset = chain_dataset(Recording("r", NOTHING, loads=(load_of(waves(1)), load_of(waves(2, 4)))))
    (batch,) = batches_of(dataset, "train")
    assert batch.loads is not None
    system, start = nominal(dataset), START.reshape(1, -1)
    whole = respond(system, start[None], SAMPLES, batch.loads)[0, 0]
    motion, cut = motion_of(system, start, SAMPLES, batch.loads), batch.cut(60)
    pieces = respond(system, motion.now[:300:60].transpose(1, 0, 2), 60, cut.loads)[0]
    np.testing.assert_allclose(pieces.reshape(300, -1), whole[:300], atol=1e-10)  # rounding
    free = motion_of(system, start, SAMPLES)
    between = loaded_states(system, batch.loads, 0.5 / RATE)
    np.testing.assert_allclose(between, motion.between - free.between, atol=1e-10)


def test_late_and_scaled_sensors_show_the_load_late_and_scaled() -> None:
    forces, delay, gain = waves(3, node=1), 0.13, 1.2
    config = FreeConfig((SAMPLES - 1) / RATE, 100.0, 0.01)
    rest = np.zeros((1, 4))
    motion = simulate_free(four_dof().with_effects(*forces), rest, rest, config, progress=False)
    recorded = CubicSpline(motion.time, motion.channel(1, "x", "acceleration")[0])
    expected = gain * recorded(np.arange(SAMPLES) / RATE - delay)
    dataset = chain_dataset(Recording("r", NOTHING, loads=(load_of(forces),)))
    (batch,) = batches_of(dataset, "train")
    a1 = np.eye(4)[[FITTED.index(SENSORS[1])]]
    faulty = replace(nominal(dataset), delay=delay * a1, gain=1 + (gain - 1) * a1)
    shown = respond(faulty, np.zeros((1, 1, 8)), SAMPLES, batch.loads)[0, 0] @ a1[0]
    # Two samples later the load had begun; a spline is off by 2e-5 of a force at 0.6 Hz, and by more at its ends.
    assert np.abs(shown - expected)[2:].max() < 2e-4 * np.abs(expected).max()
    assert np.abs(np.roll(shown, -1) - expected)[2:-1].max() > 0.05 * np.abs(expected).max()


def test_a_body_that_moves_freely_is_pushed_away() -> None:
    forces = waves(4, node=3)
    truth = chain_motion(forces, START, StiffnessChange((1,), 0.0))[:, :4]
    dataset = chain_dataset(Recording("r", NOTHING, loads=(load_of(forces),)))
    (batch,) = batches_of(dataset, "train")
    plant = plant_of(dataset)
    motion = Motion(START, START)
    (lost,) = (
        c
        for c in all_candidates(plant, dataset, motion, EVERY)
        if c.kind == "stiffness_change" and c.location == {"element": 1}
    )
    hypothesis = Hypothesis(plant, (lost,))
    theta = np.zeros((1, hypothesis.nuisances + 1))
    shown = respond(hypothesis.system(theta, FITTED, RATE, EVERY), START.reshape(1, 1, -1), SAMPLES, batch.loads)[0, 0]
    # SOFT springs, of 1e-8 of the highest eigenvalue, hold it back by half that times (omega T)^2, here 5e-5.
    assert np.abs(shown - truth).max() < 1e-4 * np.abs(truth).max()


@pytest.mark.parametrize("law", [None, CubicSpring((10,), "y", 1e8)], ids=["linear", "cubic"])
def test_bridge_under_a_load_moves_as_with_all_its_modes(law: CubicSpring | None) -> None:
    rate, samples, many = 100.0, 400, 120
    amplitudes = 5.0 * (-1.0) ** np.arange(12)  # which begin softly: their sum and its slope are zero
    frequencies = np.linspace(1, 15, 12)
    forces = tuple(HarmonicForce(8, "y", *pair, np.pi / 2) for pair in zip(amplitudes, frequencies, strict=True))
    modal = natural_modes(linearise(bridge()), many)
    rows = [modal.dofs.row(sensor.node, sensor.direction) for sensor in BRIDGE_SENSORS]
    laws: tuple[ForceLaw, ...] = forces if law is None else (*forces, law)
    rest = np.zeros((many, 1)), np.zeros((many, 1))
    truth = modal_march(modal, rest, Grid(0.0, 1 / rate, samples - 1, 20), rows, laws)[2, ..., 0]  # (time, sensor)
    recording = Recording("r", truth[None], loads=(load_of(forces, samples, rate),))
    model = bridge() if law is None else bridge().with_effects(law)

    def error(modes: int | None = None, forget: bool = False) -> float:
        dataset = Dataset(model, rate, BRIDGE_SENSORS, (recording,), 30.0, Assumptions(modes=modes))
        (batch,) = batches_of(dataset, "train")
        hypothesis = Hypothesis(plant_of(dataset))
        theta = np.zeros((1, hypothesis.nuisances))
        system = hypothesis.system(theta, BRIDGE_SENSORS, rate, (-1,) * len(BRIDGE_SENSORS))
        assert system.loads is not None
        if forget:
            system = replace(system, loads=replace(system.loads, bent=0 * system.loads.bent))
        shown = respond(system, np.zeros((1, 1, 2 * hypothesis.size)), samples, batch.loads)[0, 0]
        off = lowpassed(shown - truth, rate, 30.0)[20:-20]  # without its ends
        return float((np.abs(off).max(axis=0) / np.abs(truth).max(axis=0)).max())

    print(error(40), error(), error(forget=True))
    assert error(modes=40) < 5e-3  # a spline at 15 Hz is off by 1e-3, its ends and the start by more
    assert error() < 0.25 * error(forget=True)  # the share that is not bent, (15 Hz / 33 Hz)^2, and a margin
    assert error(forget=True) > 0.05
