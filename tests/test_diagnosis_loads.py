"""Recordings under known loads: their motion against other solvers, and what a diagnosis makes of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import lfilter

from benchmarks.blind_cases import SENSORS
from benchmarks.blind_cases.bridge import SENSORS as BRIDGE_SENSORS
from benchmarks.blind_cases.marching import Grid, integrate_motion
from benchmarks.peers.certain import certain_of
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import AddedMass, CubicSpring, Effect, ForceLaw, HarmonicForce, StiffnessChange
from fe_models.causes.places import Motion
from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset, save_dataset
from fe_models.interpolant import courses_of
from fe_models.measurement import lowpassed
from fe_models.modes import natural_modes
from fe_models.recordings import Assumptions, Dataset, Load, Recording
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.fitting.crossvalidation import as_recordings
from hybrid.diagnosis.fitting.driven import fitted_motion
from hybrid.diagnosis.fitting.forecast_score import forecast, model_of
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.loads import Loads, loads_of
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.batches import batches_of
from hybrid.diagnosis.recorded.noise_model import SensorRoles
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.loaded import loaded_channels, loaded_states
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import LoadInput, System
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose

RATE, SAMPLES = 10.0, 301
FITTED = tuple(sensor for sensor in SENSORS if sensor.role == "measured")
EVERY = tuple(range(len(FITTED)))
OUTPUTS = SensorOutputs(FITTED, RATE, EVERY)
HarmonicForces = tuple[HarmonicForce, ...]  # of which known loads are made, so that other solvers know them as effects


def harmonic_forces(
    seed: int, node: int = 2, size: float = 0.3, highest: float = 0.6, count: int = 8
) -> HarmonicForces:
    """Return harmonic forces (N) between zero and the ``highest`` frequency (Hz), random in phase."""
    rng = np.random.default_rng(seed)
    frequencies = highest * (np.arange(count) + rng.uniform(0.1, 0.9, count)) / count
    return tuple(HarmonicForce(node, "x", size, float(f), float(rng.uniform(0, 2 * np.pi))) for f in frequencies)


def load_of(forces: HarmonicForces, samples: int = SAMPLES, rate: float = RATE) -> Load:
    time = np.arange(samples) / rate
    return Load(forces[0].node, forces[0].direction, np.sum([-wave.force(0, 0, time) for wave in forces], axis=0))


def chain_motion(forces: HarmonicForces, start: FloatArray, *effects: Effect) -> FloatArray:
    """Return what Exudyn shows (time, sensor) from a ``start`` (2, dof): displacement and velocity."""
    config = FreeConfig((SAMPLES - 1) / RATE, RATE, 0.01)
    structure = four_dof().with_effects(*effects, *forces)
    motion = simulate_free(structure, start[:1], start[1:], config, progress=False)
    return np.stack([motion.shown(s)[0] for s in SENSORS], axis=-1)


def chain_dataset(*parts: Recording) -> Dataset:
    return Dataset(four_dof(), RATE, SENSORS, parts)


def system_with(dataset: Dataset, *laws: Effect) -> System:
    nominal = nominal_model_of(replace(dataset, model=four_dof().with_effects(*laws)))
    hypothesis = Hypothesis(nominal)
    return system_of(hypothesis, np.zeros((1, hypothesis.nuisances)), OUTPUTS)


START = np.random.default_rng(0).standard_normal((2, 4))
NOTHING = np.zeros((1, SAMPLES, len(SENSORS)))


@pytest.mark.parametrize("laws", [(), (CubicSpring((1,), "x", 0.5),)], ids=["linear", "cubic"])
def test_chain_under_a_load_moves_as_in_exudyn(laws: tuple[Effect, ...]) -> None:
    forces = harmonic_forces(1, node=3)
    truth = chain_motion(forces, START, *laws)[:, :4]
    dataset = chain_dataset(Recording("r", truth[None], loads=(load_of(forces),)))
    (batch,) = batches_of(dataset, "train")
    system = system_with(dataset, *laws)
    states = START.reshape(1, 1, -1)
    error, without = (
        np.abs(respond(system, states, SAMPLES, loads)[0, 0] - truth).max() for loads in (batch.loads, None)
    )
    assert without > 0.3 * np.abs(truth).max()  # the load is felt
    # A spline of degree seven through samples of a force at 0.6 Hz is off by (omega h)^8 / 1.2e6 = 3e-10, where a cubic
    # one would be by 3e-5; the law's own steps by some 1e-6.
    assert error < (1e-5 if laws else 1e-8) * np.abs(truth).max()


def test_segments_continue_each_other() -> None:
    dataset = chain_dataset(
        Recording("r", NOTHING, loads=(load_of(harmonic_forces(1)), load_of(harmonic_forces(2, 4))))
    )
    (batch,) = batches_of(dataset, "train")
    assert batch.loads is not None
    system, start = system_with(dataset), START.reshape(1, -1)
    whole = respond(system, start[None], SAMPLES, batch.loads)[0, 0]
    motion, cut = fitted_motion(system, start, batch), batch.cut(60)
    pieces = respond(system, motion.now[:300:60].transpose(1, 0, 2), 60, cut.loads)[0]
    np.testing.assert_allclose(pieces.reshape(300, -1), whole[:300], atol=1e-10)  # rounding
    free = fitted_motion(system, start, replace(batch, loads=None))
    between = loaded_states(system, batch.loads, 0.5 / RATE)
    np.testing.assert_allclose(between, motion.between - free.between, atol=1e-10)


def test_late_and_scaled_sensors_show_the_load_late_and_scaled() -> None:
    forces, delay, gain = harmonic_forces(3, node=1), 0.13, 1.2
    config = FreeConfig((SAMPLES - 1) / RATE, 100.0, 0.01)
    rest = np.zeros((1, 4))
    motion = simulate_free(four_dof().with_effects(*forces), rest, rest, config, progress=False)
    recorded = CubicSpline(motion.time, motion.channel(1, "x", "acceleration")[0])
    expected = gain * recorded(np.arange(SAMPLES) / RATE - delay)
    dataset = chain_dataset(Recording("r", NOTHING, loads=(load_of(forces),)))
    (batch,) = batches_of(dataset, "train")
    a1 = np.eye(4)[[FITTED.index(SENSORS[1])]]
    faulty = replace(system_with(dataset), delay=delay * a1, gain=1 + (gain - 1) * a1)
    shown = respond(faulty, np.zeros((1, 1, 8)), SAMPLES, batch.loads)[0, 0] @ a1[0]
    # Two samples later the load had begun; a spline is off by more at its ends.
    assert np.abs(shown - expected)[2:].max() < 1e-6 * np.abs(expected).max()
    assert np.abs(np.roll(shown, -1) - expected)[2:-1].max() > 0.05 * np.abs(expected).max()


def test_a_body_that_moves_freely_is_pushed_away() -> None:
    forces = harmonic_forces(4, node=3)
    truth = chain_motion(forces, START, StiffnessChange((1,), 0.0))[:, :4]
    dataset = chain_dataset(Recording("r", NOTHING, loads=(load_of(forces),)))
    (batch,) = batches_of(dataset, "train")
    nominal = nominal_model_of(dataset)
    motion = Motion(START, START)
    (lost,) = (
        c
        for c in all_candidates(nominal, dataset, motion, EVERY)
        if c.kind == "stiffness_change" and c.location == {"element": 1}
    )
    hypothesis = Hypothesis(nominal, (lost,))
    theta = np.zeros((1, hypothesis.nuisances + 1))
    system = system_of(hypothesis, theta, OUTPUTS)
    shown = respond(system, START.reshape(1, 1, -1), SAMPLES, batch.loads)[0, 0]
    # SOFT springs, of 1e-8 of the highest eigenvalue, hold it back by half that times (omega T)^2, here 5e-5.
    assert np.abs(shown - truth).max() < 1e-4 * np.abs(truth).max()


@pytest.mark.slow
@pytest.mark.parametrize("law", [None, CubicSpring((8,), "y", 1e8)], ids=["linear", "cubic"])
def test_bridge_under_a_load_moves_as_with_all_its_modes(law: CubicSpring | None) -> None:
    rate, samples, many = 100.0, 400, 120
    amplitudes = 5.0 * (-1.0) ** np.arange(12)  # which begin softly: their sum and its slope are zero
    frequencies = np.linspace(1, 15, 12)
    forces = tuple(HarmonicForce(8, "y", *pair, np.pi / 2) for pair in zip(amplitudes, frequencies, strict=True))
    modal = natural_modes(linearise(bridge()), many)
    rows = [modal.dofs.row(sensor.node, str(sensor.direction)) for sensor in BRIDGE_SENSORS]
    laws: tuple[ForceLaw, ...] = forces if law is None else (*forces, law)
    rest = np.zeros((many, 1)), np.zeros((many, 1))
    truth = integrate_motion(modal, rest, Grid(0.0, 1 / rate, samples - 1, 20), rows, laws)[2, ..., 0]  # (time, sensor)
    recording = Recording("r", truth[None], loads=(load_of(forces, samples, rate),))
    model = bridge() if law is None else bridge().with_effects(law)

    def error(modes: int | None = None, forget: bool = False) -> float:
        dataset = Dataset(model, rate, BRIDGE_SENSORS, (recording,), 30.0, Assumptions(modes=modes))
        (batch,) = batches_of(dataset, "train")
        hypothesis = Hypothesis(nominal_model_of(dataset))
        theta = np.zeros((1, hypothesis.nuisances))
        system = system_of(hypothesis, theta, SensorOutputs.faultless(BRIDGE_SENSORS, rate))
        assert system.loads is not None
        if forget:
            system = replace(system, loads=replace(system.loads, bent=0 * system.loads.bent))
        shown = respond(system, np.zeros((1, 1, 2 * hypothesis.size)), samples, batch.loads)[0, 0]
        off = lowpassed(shown - truth, rate, 30.0)[20:-20]  # without its ends
        return float((np.abs(off).max(axis=0) / np.abs(truth).max(axis=0)).max())

    assert error(modes=40) < 1e-3  # a spline at 15 Hz is off by 1e-6, its ends by more
    bent, without = error(), error(forget=True)
    assert without > 0.05
    # Of three terms (15 Hz / 33 Hz)^6 = 0.01 is left, of one 0.2; a cubic spring's own pull goes up to 45 Hz.
    assert bent < (0.02 if law is None else 0.03) * without


def recorded(
    seed: int, *effects: Effect, free: int = 0, node: int = 2, highest: float = 0.6, count: int = 8
) -> Dataset:
    """Return five recordings of 30 s with 3 % noise: under loads, from rest, but for the ``free`` first ones."""
    rng = np.random.default_rng(seed)
    recordings, level = [], np.zeros(len(SENSORS))
    for number in range(5):
        forces = () if number < free else harmonic_forces(10 * seed + number, node, highest=highest, count=count)
        states = (1.0 if number < free else 0.0) * rng.standard_normal((2, 4))
        data = chain_motion(forces, states, *effects)
        level = level if number else 0.03 * data.std(axis=0)
        data = data + level * rng.standard_normal(data.shape)
        loads = (load_of(forces),) if forces else ()
        recordings.append(Recording(f"r{number}", data[None], "test" if number == 4 else "train", loads))
    return chain_dataset(*recordings)


def check_named(found: Diagnosis, kind: str, location: dict[str, object], value: float) -> None:
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == (kind, location)
    (size,) = finding.parameters.values()
    assert abs(size.value - value) < 3 * size.std
    assert finding.probability > 0.9
    assert found.verdict is Verdict.EXPLAINED
    extended = found.scores["extended"]["measured"]
    assert extended is not None
    assert extended < 1.1 * found.noise_floor


@pytest.mark.slow
def test_nothing_is_wrong_under_a_load_far_above_all_modes() -> None:
    dataset = recorded(1, highest=4.9, count=40)
    found = diagnose(dataset)
    assert found.verdict is Verdict.NOTHING_WRONG
    assert found.findings == ()


@pytest.mark.slow
def test_a_lost_spring_is_named_from_loaded_and_free_recordings(tmp_path: Path) -> None:
    path = save_dataset(recorded(2, StiffnessChange((3,), 0.8), free=2), tmp_path, "four_dof")
    check_named(diagnose(load_dataset(path)), "stiffness_change", {"element": 3}, 0.8)


@pytest.mark.slow
def test_a_cubic_spring_is_named_from_recordings_that_begin_at_rest() -> None:
    found = diagnose(recorded(3, CubicSpring((1,), "x", 0.3)))
    check_named(found, "cubic_spring", {"node": 1, "direction": "x"}, 0.3)


@pytest.mark.slow
def test_added_mass_under_a_fast_load_is_not_taken_for_noise() -> None:
    dataset = recorded(4, AddedMass(3, 0.6), node=3, highest=4.9, count=40)
    setting = setting_of(dataset)
    data = chain_motion(harmonic_forces(40, 3, highest=4.9, count=40), np.zeros((2, 4)), AddedMass(3, 0.6))
    level = 0.03 * data.std(axis=0)[list(setting.measured)]
    # of 4 times 75 lines; their power is known to 8 %
    assert setting.noise_model.sigma == pytest.approx(level, rel=0.15)
    check_named(diagnose(dataset), "added_mass", {"node": 3}, 0.6)


def test_a_load_of_the_wrong_sign_fits_nothing() -> None:
    dataset = recorded(5)

    def left(sign: float) -> float:
        turned = [
            replace(r, loads=tuple(replace(load, values=sign * load.values) for load in r.loads))
            for r in dataset.recordings
        ]
        setting = setting_of(replace(dataset, recordings=tuple(turned)))
        found = fit(
            setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths.whole, setting.noise_model
        )
        assert found is not None
        return found.chi2 / found.values

    assert left(1.0) == pytest.approx(1.0, abs=0.1)
    assert left(-1.0) > 50


def test_a_free_recording_is_forecast_by_what_was_fitted_from_rest() -> None:
    loaded, free = recorded(6), recorded(7, free=5)
    recordings = (*loaded.select("train"), replace(free.recordings[0], name="free", role="test"))
    setting = setting_of(replace(loaded, recordings=recordings))
    item = fit(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths.whole, setting.noise_model
    )
    assert item is not None
    batches = batches_of(setting.dataset, "test")
    found = forecast(model_of(item, setting.noise_model), batches, SensorRoles(SENSORS, EVERY, setting.noise_model))
    level = 0.03 * free.recordings[0].data[0].std(axis=0) / np.ptp(free.recordings[0].data[0], axis=0)
    assert found.nrmse[0, :4].mean() < 1.2 * level[:4].mean()  # 0.03 is of the motion without noise


def test_loads_are_batched_cut_and_halved_with_their_recordings() -> None:
    first, second = (load_of(harmonic_forces(seed, node)) for seed, node in ((1, 2), (2, 4)))
    data = np.random.default_rng(0).standard_normal((3, SAMPLES, 5))
    several = Recording("several", data[:2], loads=(first,))
    dataset = chain_dataset(several, Recording("free", data[:1]), Recording("both", data[2:], loads=(first, second)))
    loaded, free = batches_of(dataset, "train")
    assert (loaded.names, free.names) == (("several", "several", "both"), ("free",))
    assert free.loads is None
    assert loaded.loads is not None
    assert loaded.loads.places == ((2, "x"), (4, "x"))
    force = loaded.loads.courses[0]  # (recording, time, place)
    np.testing.assert_allclose(force[[0, 1, 2], :, 0], [first.values] * 3)
    np.testing.assert_allclose(force[[0, 2], :, 1], [0 * second.values, second.values])
    last = loaded.cut(100).take([2])
    assert last.loads is not None
    np.testing.assert_array_equal(last.loads.courses[0].reshape(300, 2), force[2, :300])
    halves, _ = as_recordings(chain_dataset(Recording("both", data[2:], loads=(first, second))))
    np.testing.assert_array_equal(halves.recordings[1].loads[1].values, second.values[150:300])


@pytest.mark.parametrize(("share", "lost"), [(0.1, 1e-7), (0.3, 2.5e-3)])
def test_a_load_between_samples_is_as_smooth_as_what_was_sampled(share: float, lost: float) -> None:
    """Of degree seven it is off by (2 pi share)^8 / 1.2e6 at most where that is small; a cubic one by 4e-4, 7e-2."""
    samples, often = 400, 10
    courses = courses_of(np.cos(2 * np.pi * share * np.arange(samples))[None, :, None], 1.0)
    finer = Loads.of(((1, "x"),), courses, 1.0).finer(often).courses[0, 0, :, 0]
    truth = np.cos(2 * np.pi * share * np.arange(samples * often) / often)
    inner = slice(50 * often, -50 * often)  # its ends are not as smooth
    assert np.abs(finer - truth)[inner].max() < lost


def test_a_load_of_few_samples_has_the_orders_that_these_tell() -> None:
    time: FloatArray = 0.1 * np.arange(4, dtype=float)
    courses = courses_of(np.power(time, 3.0)[None, :, None], 0.1)[:, 0, :, 0]
    np.testing.assert_allclose(courses[:4], [time**3, 3 * time**2, 6 * time, 0 * time + 6], atol=1e-10)  # rounding
    assert not courses[4:].any()


def test_peers_refuse_loads() -> None:
    with pytest.raises(InputError, match="free vibrations only"):
        certain_of(chain_dataset(Recording("r", NOTHING, loads=(load_of(harmonic_forces(1)),))))


def test_a_load_passes_the_low_pass_of_recordings_that_it_has_not_passed_however_little_lies_above() -> None:
    """With 3 % above, the load was used as it was, and a clean chain's sensor had a gain of 0.96."""
    rate, lowpass, samples = 100.0, 30.0, 4000
    white = np.random.default_rng(4).standard_normal((samples, 1))
    wide = lfilter([1.0], [1.0, -0.9], white[:, 0])[:, None]  # a first-order low-pass at 1.7 Hz
    passed = lowpassed(wide, rate, lowpass)
    power = np.abs(np.fft.rfft(wide[:, 0])) ** 2
    above = np.fft.rfftfreq(samples, 1 / rate) > lowpass
    assert power[above].sum() < 0.03 * power.sum()
    for given, used in ((wide, passed), (passed, passed)):
        recording = Recording("r", np.zeros((1, samples, len(SENSORS))), loads=(Load(1, "x", given[:, 0]),))
        found = loads_of([recording], samples, Dataset(four_dof(), rate, SENSORS, (recording,), lowpass))
        assert found is not None
        np.testing.assert_allclose(found.courses[0, 0], used, atol=1e-12)


def test_a_mass_that_a_candidate_leaves_without_any_spring_goes_on_under_its_load() -> None:
    """Both roots are zero there and nothing sets a scale, which ended a diagnosis of one mass in an AssertionError."""
    samples, step = 200, 0.01
    free, nothing = np.array([[[0.0, 1.0], [0.0, 0.0]]]), np.zeros((1, 1))
    push, shown = np.array([[[0.0], [1.0]]]), np.array([[[1.0, 0.0]]])
    bent = np.zeros((8, 1, 1))
    entry = LoadInput(((1, "x"),), push, np.zeros((1, 1, 1)), bent, bent[:, :0], nothing + 1, nothing)
    lawless = np.zeros((1, 2, 0)), shown, np.zeros((1, 1, 0)), np.zeros((1, 0, 2)), ()
    system = System(free, *lawless, nothing + 1, nothing, nothing, step, None, entry)
    loads = Loads.of(((1, "x"),), courses_of(np.ones((1, samples, 1)), step), step)
    time = step * np.arange(samples)
    found = loaded_channels(system, loads)[0, 0, :, 0]
    np.testing.assert_allclose(found, time**2 / 2, atol=1e-6)  # of 2 m, which a spring of (1e-5 rad/s)^2 does not feel
