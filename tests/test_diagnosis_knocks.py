"""Hammers: knocks of a few samples, behind a low-pass or not yet."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh, expm

from fe_models.arrays import FloatArray
from fe_models.interpolant import courses_of
from fe_models.measurement import lowpassed
from fe_models.recordings import Assumptions, Dataset, Load, Recording, Sensor, Uncertainty
from fe_models.structure import Damping, PointMass, Spring, Structure
from hybrid.diagnosis.report import report_table
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from hybrid.known_loads.behind_lowpass import behind
from hybrid.known_loads.quiet_loads import at_rest_as_zero, with_quiet_loads
from hybrid.known_loads.short_knocks import after_loads, without_short_knocks

RATE, FINE, SAMPLES, LOWPASS = 1000.0, 50, 600, 300.0  # Hz, steps to a sample, samples, Hz


def knock(width: float, begin: float = 0.1003) -> FloatArray:
    """Return half a sine of a ``width`` (s), of size one, in fine steps (fine time,)."""
    phase = np.pi * (np.arange(SAMPLES * FINE) / RATE / FINE - begin) / width
    return np.where((phase > 0) & (phase < np.pi), np.sin(phase), 0.0)


@pytest.mark.parametrize(("width", "error"), [(0.002, 0.06), (0.003, 0.03), (0.005, 0.015)])
def test_a_knock_that_has_passed_no_filter_passes_that_of_the_recordings(width: float, error: float) -> None:
    """What is left is what samples do not tell of so short a knock; as it was, it would be off by 37, 12 and 3 %."""
    fine = knock(width)
    passed = lowpassed(fine[:, None], RATE * FINE, LOWPASS)[::FINE, 0]
    sampled = fine[::FINE]
    assert np.abs(sampled - passed).max() > 2 * error * passed.max()
    assert np.abs(behind(sampled, RATE, LOWPASS) - passed).max() < error * passed.max()


@pytest.mark.parametrize("width", [0.002, 0.003, 0.005, 0.02])
def test_a_knock_that_has_passed_it_is_left_as_it_is(width: float) -> None:
    passed = lowpassed(knock(width)[:, None], RATE * FINE, LOWPASS)[::FINE, 0]
    np.testing.assert_array_equal(behind(passed, RATE, LOWPASS), passed)


def test_a_sweep_that_has_passed_it_is_left_as_it_is() -> None:
    time = np.arange(SAMPLES * FINE) / RATE / FINE
    sweep = np.sin(2 * np.pi * (5 * time + 300 * time**2))  # from 5 to 365 Hz
    passed = lowpassed(sweep[:, None], RATE * FINE, LOWPASS)[::FINE, 0]
    np.testing.assert_array_equal(behind(passed, RATE, LOWPASS), passed)


@pytest.mark.parametrize(("width", "lost"), [(0.003, 0.03), (0.005, 0.012)])
def test_the_impulse_of_an_unfiltered_knock_is_that_of_its_samples_nearly(width: float, lost: float) -> None:
    courses = courses_of(knock(width)[::FINE][None, :, None], 1 / RATE)[:, 0, :, 0]
    per_step = sum(courses[order] / RATE ** (order + 1) / np.prod(np.arange(1, order + 2)) for order in range(8))
    assert float(np.sum(per_step)) == pytest.approx(2 * width / np.pi, rel=lost)


CARTS = Structure(
    name="carts",
    nodes=((0.0, 0.0), (1.0, 0.0)),
    directions=("x",),
    elements=(Spring((1,), "x", 4e5), Spring((1, 2), "x", 3e5)),
    point_masses=(PointMass(1, 2.0), PointMass(2, 3.0)),
    damping=Damping(modal_ratios=(0.01,)),
)
SENSORS = tuple(Sensor(f"a{node}", node, "x", "acceleration", "m/s^2") for node in (1, 2))


def answered(force: FloatArray, factor: float = 1.0) -> FloatArray:
    """Return the accelerations (fine time, cart) under a ``force`` on the second cart, straight in each fine step;
    ``factor``: on the second spring.
    """
    M, second = np.diag([2.0, 3.0]), 3e5 * factor
    K = np.array([[4e5 + second, -second], [-second, second]])
    omega2, shapes = eigh(K, M)
    C = M @ shapes @ np.diag(0.02 * np.sqrt(omega2)) @ shapes.T @ M
    h, A = 1 / RATE / FINE, np.zeros((6, 6))
    A[:2, 2:4], A[2:4, :2], A[2:4, 2:4] = np.eye(2), -np.linalg.solve(M, K), -np.linalg.solve(M, C)
    A[3, 4], A[4, 5] = 1 / 3.0, 1 / h
    step, z, found = expm(A * h), np.zeros(4), np.empty((force.size - 1, 2))
    for k in range(force.size - 1):
        found[k] = A[2:4, :4] @ z + [0, force[k] / 3.0]
        z = step[:4, :4] @ z + step[:4, 4] * force[k] + step[:4, 5] * (force[k + 1] - force[k])
    return found


def knocked(width: float, factor: float = 1.0, lowpass: float | None = None) -> Dataset:
    """Return three recordings of knocks, unfiltered, of about that ``width`` (s); sensors behind a ``lowpass`` (Hz)."""
    rng, recordings = np.random.default_rng(1), []
    for number in range(3):
        force = 500 * knock(width * rng.uniform(0.9, 1.1), 0.1 + 1e-3 * rng.random())
        data = lowpassed(answered(force, factor), RATE * FINE, lowpass)[::FINE]
        data = data + 0.01 * data.std(axis=0) * rng.standard_normal(data.shape)
        loads = (Load(2, "x", force[::FINE][: len(data)]),)
        recordings.append(Recording(f"k{number}", data[None], "test" if number == 2 else "train", loads))
    uncertain = Assumptions(uncertainty=Uncertainty(0.02, 0.02, 0.2))
    return Dataset(CARTS, RATE, SENSORS, tuple(recordings), lowpass, uncertain)


@pytest.mark.slow
@pytest.mark.parametrize(("width", "lowpass"), [(0.005, None), (0.003, 300.0)])
def test_a_softer_spring_is_named_by_what_moves_after_an_unfiltered_knock(width: float, lowpass: float | None) -> None:
    """Fitted as a load the knock's impulse, off by 1 %, left far more than noise, and nothing was named."""
    report = report_table(diagnose(knocked(width, 0.9, lowpass)))
    (finding,) = report["findings"]
    assert (finding["kind"], finding["location"]) == ("stiffness_change", {"element": 2})
    found = finding["parameters"]["factor"]
    assert found["value"] == pytest.approx(0.9, abs=3 * found["std"])


def test_recordings_of_short_knocks_begin_after_them() -> None:
    dataset, (note,) = without_short_knocks(knocked(0.003))
    assert "the knocks of k0, k1, k2 are too short" in note
    for recording in dataset.recordings:
        assert not recording.loads
        assert 104 <= recording.skipped <= 107  # the knocks end 3.7 ms after the 100th sample at most, and two more


def test_what_comes_after_loads_is_most_of_a_recording_or_all_of_it_stays() -> None:
    first, second, _ = knocked(0.02).recordings
    after = after_loads(first)
    assert not after.loads
    assert 120 <= after.skipped <= 125  # the knock lasts 20 samples after the 100th
    late = replace(second, loads=tuple(replace(load, values=np.roll(load.values, -150)) for load in second.loads))
    assert after_loads(late) is late
    assert after_loads(after) is after


def test_noise_of_a_load_cell_at_rest_is_no_force() -> None:
    """Less the offset, a blow stays as it is; 8 samples beside it cover what a filter's ringing has above the noise."""
    rng = np.random.default_rng(2)
    passed = lowpassed(500 * knock(0.003)[:, None], RATE * FINE, LOWPASS)[::FINE, 0]
    noise = 0.5 * rng.standard_normal(passed.shape)
    found = at_rest_as_zero(passed + noise + 3.0)
    acts = np.abs(passed) > 10 * 0.5
    assert acts.sum() >= 4
    np.testing.assert_allclose(found[acts], (passed + noise)[acts], atol=0.1)  # of the median of 600 values: 0.025
    assert (found[:80] == 0).all()
    assert (found[140:] == 0).all()


@pytest.mark.parametrize("kind", ["exact", "random", "sweep", "steady", "ringing"])
def test_a_load_that_is_never_at_rest_or_without_noise_stays_as_it_is(kind: str) -> None:
    rng, time = np.random.default_rng(3), np.arange(SAMPLES) / RATE
    passed = lowpassed(500 * knock(0.02)[:, None], RATE * FINE, LOWPASS)[::FINE, 0]
    values = {
        "exact": 500 * knock(0.02)[::FINE],
        "random": rng.standard_normal(SAMPLES),
        "sweep": np.sin(2 * np.pi * (5 * time + 100 * time**2)),
        "steady": np.full(SAMPLES, 3.0),
        "ringing": passed + 1e-12 * rng.standard_normal(SAMPLES),
    }[kind]
    assert at_rest_as_zero(values) is values


def test_a_note_names_the_recordings_whose_loads_were_noise_at_rest() -> None:
    dataset, rng = knocked(0.02), np.random.default_rng(4)
    first, *others = dataset.recordings
    (load,) = first.loads
    noisy = replace(load, values=load.values + 0.5 * rng.standard_normal(load.values.shape))
    given = replace(dataset, recordings=(replace(first, loads=(noisy,)), *others))
    found, notes = with_quiet_loads(given)
    assert notes == ["beside their blows the forces of k0 are noise of the load cell: there they count as zero"]
    assert found.recordings[1:] == given.recordings[1:]
    assert with_quiet_loads(dataset) == (dataset, [])


@pytest.mark.slow
def test_knocks_whose_samples_tell_their_force_stay_loads() -> None:
    """Those that last many samples, those that a filter has widened, and what is no knock."""
    long, filtered, lasting = knocked(0.02), knocked(0.003), knocked(0.003)
    passed = lowpassed(500 * knock(0.003)[:, None], RATE * FINE, LOWPASS)[::FINE, 0]
    (first, *_) = filtered.recordings
    swept = np.sin(0.2 * np.arange(first.data.shape[1]))
    for dataset, values in ((long, None), (filtered, passed), (lasting, swept)):
        recordings = dataset.recordings
        if values is not None:
            load = Load(2, "x", values[: first.data.shape[1]])
            recordings = tuple(Recording(r.name, r.data, r.role, (load,)) for r in recordings)
        kept, notes = without_short_knocks(Dataset(CARTS, RATE, SENSORS, recordings))
        assert (kept.recordings, notes) == (recordings, [])
