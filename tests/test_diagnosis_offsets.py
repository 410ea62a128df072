"""Offsets of accelerometers: distinguished from drifts, noise and what a structure does itself, and taken off."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import GapStop, SupportSpring
from fe_models.causes.time_integration import root
from fe_models.four_dof_data import paper_dataset
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording, Sensor
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.offsets import (
    NOTE_DIFFERING,
    NOTE_DISPLACED,
    NOTE_HELD_OUT,
    NOTE_TAKEN_OFF,
    without_offsets,
)
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from tests.frames import portal
from tests.masts import recorded

RATE, SAMPLES = 50.0, 1500
POLES = root(2 * np.pi * np.array([1.0, 3.0]), np.full(2, 0.01))  # thirty periods of the slower one
NOISE = 0.02
SENSOR = Sensor("a", 1, "x", "acceleration", "m/s^2")


def decays(count: int = 4, samples: int = SAMPLES, seed: int = 0, noise: float = NOISE) -> FloatArray:
    """Free vibrations in two modes, both a few per cent off, with noise: (recording, time)."""
    rng, time = np.random.default_rng(seed), np.arange(samples) / RATE
    size = rng.standard_normal((count, 2)) + 1j * rng.standard_normal((count, 2))
    motion = np.real(size @ np.exp(np.outer(np.array([0.96, 1.03]) * POLES, time)))
    return np.asarray(motion + noise * rng.standard_normal(motion.shape))


def dataset(channels: FloatArray, sensor: Sensor = SENSOR) -> Dataset:
    """Recordings of one channel each (recording, time), the last one for testing."""
    parts = tuple(
        Recording(f"r{i}", channel[None, :, None], "test" if i == len(channels) - 1 else "train")
        for i, channel in enumerate(channels)
    )
    return Dataset(four_dof(), RATE, (sensor,), parts)


def left(given: Dataset, clean: FloatArray) -> FloatArray:
    """What a dataset has beyond clean channels, (recording, time)."""
    return np.stack([r.data[0, :, 0] for r in given.recordings]) - clean


@pytest.mark.parametrize("size", [0.02, 0.5, -9.81])  # as much as the noise, as the motion, gravity
@pytest.mark.parametrize("slope", [0.0, 0.05])
def test_offset_is_taken_off_to_within_its_own_error_and_a_drift_is_left(size: float, slope: float) -> None:
    clean = decays() + slope * np.arange(SAMPLES) / RATE
    found, (note,) = without_offsets(dataset(clean + size), POLES)
    own = NOISE / np.sqrt(3 * SAMPLES)  # of a mean over the training recordings ...
    error = 2 * own if slope else own  # ... or of a line's beginning, see the variance of a regression
    rest = left(found, clean)
    assert np.ptp(rest) < 1e-12  # one value of all recordings, the test recording's too
    assert abs(rest[0, 0]) < 4 * error  # the averages do not use a recording's ends in full
    assert note.startswith(f"{NOTE_TAKEN_OFF}: a ")
    # three digits are reported
    assert float(note.split()[-2]) == pytest.approx(size, abs=4 * error + 0.005 * abs(size))


@pytest.mark.slow
def test_neither_noise_nor_a_drift_is_an_offset() -> None:
    """One in a million by chance, if the noise is white."""
    for seed in range(100):
        for slope in (0.0, 0.002, 0.05):
            given = dataset(decays(seed=seed) + slope * np.arange(SAMPLES) / RATE)
            assert without_offsets(given, POLES) == (given, [])


def test_recordings_without_noise_have_no_offsets_by_rounding_and_show_small_ones() -> None:
    given = dataset(decays(noise=0.0))
    assert without_offsets(given, POLES) == (given, [])
    found, (note,) = without_offsets(dataset(decays(noise=0.0) + 0.05), POLES)
    assert note.startswith(NOTE_TAKEN_OFF)
    rest = np.abs(left(found, decays(noise=0.0))).max()
    assert rest < 1e-6  # the rounding of poles that are estimated from squares of the motion


def test_offsets_that_differ_are_reported_and_left() -> None:
    given = dataset(decays() + np.array([[0.1], [-0.1], [0.2], [0.0]]))
    found, (note,) = without_offsets(given, POLES)
    assert found is given
    assert note == f"{NOTE_DIFFERING}: a -0.1 to 0.2 m/s^2"
    # Nearly alike, they are one: what is left is far less than what was there.
    clean = decays()
    found, (note,) = without_offsets(dataset(clean + np.array([[1.0], [1.1], [1.0], [1.05]])), POLES)
    assert note.startswith(NOTE_TAKEN_OFF)
    assert np.abs(left(found, clean)).max() < 0.1  # as far as the offsets are apart


@pytest.mark.parametrize("stiffness", [0.5, 1.0])
def test_what_two_periods_of_a_motion_that_is_not_linear_leave_is_no_offset(stiffness: float) -> None:
    """Twelve motions of the chain with a hidden cubic spring, as the README has them, two periods of its first mode.

    No sum of decays explains them; what these leave is slow, and its mean differs from recording to recording.
    """
    found = paper_dataset(stiffness, realisations=12, progress=False)
    nominal = natural_modes(found.model, 4)
    given, notes = without_offsets(found, root(nominal.omega, nominal.damping_ratio))
    assert notes == []
    assert given is found
    # The offset of a sensor still shows beside it, where it is far larger than what motion leaves.
    off = np.where(np.arange(12) == 0, 20.0, 0.0)  # x1, which moves by metres
    shifted = replace(found, recordings=tuple(replace(r, data=r.data + off) for r in found.recordings))
    _, (note,) = without_offsets(shifted, root(nominal.omega, nominal.damping_ratio))
    assert "x1 20" in note or "x1 19.9" in note


def test_held_out_sensors_displacements_and_short_recordings_are_left() -> None:
    held_out = dataset(decays() + 0.5, replace(SENSOR, role="held_out"))
    found, (note,) = without_offsets(held_out, POLES)
    assert found is held_out
    assert note.startswith(f"{NOTE_HELD_OUT}: a 0.5")
    settled = dataset(decays() + 0.5, replace(SENSOR, quantity="displacement"))
    found, (note,) = without_offsets(settled, POLES)
    assert found is settled
    assert note.startswith(f"{NOTE_DISPLACED}: a 0.5")
    short = dataset(decays(samples=60) + 0.5)  # 1.2 periods
    assert without_offsets(short, POLES) == (short, [])


@pytest.mark.slow
def test_stop_on_one_side_moves_the_mean_of_displacements_only() -> None:
    """A frame that knocks at a stop is on its other side more often; its mean acceleration is zero all the same."""
    given = recorded(portal().with_effects(GapStop((2,), "x", gap=0.0, stiffness=2e6, side=1)))
    assert not any(note.startswith(NOTE_TAKEN_OFF) for note in setting_of(given).notes)


@pytest.mark.slow
def test_cause_is_named_beside_offsets_of_all_sensors() -> None:
    """Without them taken off, nothing on the list explains the recordings."""
    rng = np.random.default_rng(3)
    given = recorded(portal().with_effects(SupportSpring(1, "rz", 2e5)))
    rms = np.mean([r.data[0].std(axis=0) for r in given.recordings], axis=0)
    off = 0.2 * rms * rng.choice([-1, 1], len(rms))
    off_by = replace(given, model=portal(), recordings=tuple(replace(r, data=r.data + off) for r in given.recordings))
    found = diagnose(off_by)
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("support_spring", {"node": 1, "direction": "rz"})
    assert any(note.startswith(NOTE_TAKEN_OFF) for note in found.notes)
