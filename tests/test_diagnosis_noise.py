"""Noise and what is no noise, distinguished by frequency."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.built_in.four_dof import four_dof
from fe_models.measurement import lowpassed
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.nominal.lowpass import noise_is_lowpassed
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.batches import Batch, batches_of, columns_of, measured_columns
from hybrid.diagnosis.recorded.noise import (
    Band,
    correlation_factor,
    excess,
    noise_of_recordings,
    structure_band,
    variance_of_log_noise,
)
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose

RATE, BAND = 10.0, Band(0.55, room=True)  # Hz
WHITE = np.random.default_rng(0).standard_normal((9, 501, 4))
WAVE = np.sin(2 * np.pi * 0.3 * np.arange(501) / RATE)[None, :, None]


def test_white_noise_has_no_excess() -> None:
    found = excess((WHITE,), RATE, BAND)
    assert abs(found.total) < 3 * found.std  # by chance once in 400 seeds; this one is fixed
    assert not found.significant
    assert found.sigma == pytest.approx(np.ones(4), rel=0.03)


def test_a_wave_a_fifth_of_the_noise_is_seen_and_measured() -> None:
    amplitude = 0.3
    found = excess((WHITE + amplitude * WAVE,), RATE, BAND)
    assert found.significant
    energy = amplitude**2 * float(np.sum(WAVE**2)) * 9 * 4
    assert found.total == pytest.approx(energy, abs=4 * found.std)


def test_white_noise_counts_fully_and_smooth_errors_do_not() -> None:
    assert correlation_factor((WHITE,)) == 1.0
    smooth = np.cumsum(WHITE, axis=1)
    assert correlation_factor((smooth,)) > 10


def test_noise_is_estimated_from_recordings_with_motion() -> None:
    case = blind_case(4, BlindConfig(noise=0.05, train=6, test=1))
    clean = blind_case(4, BlindConfig(noise=0.0, train=6, test=1))
    columns = (0, 1, 2, 3)
    (batch,) = columns_of(batches_of(case.dataset, "train"), columns)
    (without,) = columns_of(batches_of(clean.dataset, "train"), columns)
    truth = (batch.data - without.data).std(axis=(0, 1))
    band = structure_band(nominal_model_of(case.dataset), RATE)
    found = noise_of_recordings((batch,), RATE, band)
    assert found == pytest.approx(truth, rel=0.06)  # 6 recordings, half of 250 frequencies: 2.6 % and the signal's rest


def test_low_passed_noise_has_no_excess_and_its_own_density() -> None:
    white = np.random.default_rng(1).standard_normal((6, 2000, 4))
    shown = np.stack([lowpassed(part, 100.0, 30.0) for part in white])
    band = Band(27.0, room=False)  # nothing is left above the low-pass to tell the noise from
    found = excess((shown,), 100.0, band)
    assert not found.significant
    assert abs(found.total) < 3 * found.std
    # 6 ends of 800 samples, two thirds of 1296 frequencies independent: a quartile tells the noise to 3.4 %
    assert found.sigma == pytest.approx(np.ones(4), rel=0.1)
    assert found.sigma.mean() == pytest.approx(1.0, rel=0.05)


def test_a_wave_half_as_large_as_low_passed_noise_is_seen() -> None:
    white = np.random.default_rng(1).standard_normal((6, 2000, 4))
    shown = np.stack([lowpassed(part, 100.0, 30.0) for part in white])
    wave = 0.5 * np.sin(2 * np.pi * 3.45 * np.arange(2000) / 100.0)[None, :, None]
    found = excess((shown + wave,), 100.0, Band(27.0, room=False))
    assert found.significant
    assert found.total == pytest.approx(float(np.sum(wave**2)) * 6 * 4, abs=4 * found.std)


def test_bridge_noise_is_estimated_between_the_lines_of_its_motion() -> None:
    config = BlindConfig(structure="bridge", rich=False, noise=0.03)
    case, clean = (blind_case(4, replace(config, noise=noise)) for noise in (0.03, 0.0))
    columns = measured_columns(case.dataset)
    (batch,) = columns_of(batches_of(case.dataset, "train"), columns)
    (without,) = columns_of(batches_of(clean.dataset, "train"), columns)
    band = structure_band(nominal_model_of(case.dataset), 100.0, case.dataset.lowpass)
    assert not band.room
    found = noise_of_recordings((batch,), 100.0, band)
    # the low-pass leaves 30 of 50 Hz, so that white noise as dense is stronger than what is left
    truth = (batch.data - without.data).std(axis=(0, 1)) / np.sqrt(batch.share)
    assert found == pytest.approx(truth, rel=0.2)  # 3 recordings, and the feet of their lines


def noise_after_the_lowpass(**config: Any) -> Dataset:
    """Return recordings of a clean bridge whose motion has passed 30 Hz, and whose noise came after that."""
    return blind_case(5, BlindConfig(structure="bridge", rich=False, noisy="unfiltered", **config)).dataset


def test_whether_noise_has_passed_a_lowpass_or_came_after_it_is_detected() -> None:
    passed = blind_case(5, BlindConfig(structure="bridge", rich=False, noise=0.03)).dataset
    after = noise_after_the_lowpass()
    assert noise_is_lowpassed(passed)
    assert not noise_is_lowpassed(after)
    assert not noise_is_lowpassed(replace(passed, lowpass=None))
    assert [batches_of(data, "train")[0].share for data in (passed, after)] == [0.6, 1.0]  # of 50 Hz


@pytest.mark.slow
def test_noise_that_came_after_a_lowpass_is_estimated_above_it() -> None:
    after = noise_after_the_lowpass()
    setting = setting_of(after)
    assert setting.band.room
    clean = blind_case(5, BlindConfig(structure="bridge", rich=False, noise=0.0)).dataset
    noise = np.concatenate([a.data - b.data for a, b in zip(after.select("train"), clean.select("train"), strict=True)])
    truth = noise.std(axis=(0, 1))[list(setting.measured)]
    # 3 recordings of 200 frequencies above 40 Hz: 2.9 %
    assert setting.noise_model.sigma == pytest.approx(truth, rel=0.08)


@pytest.mark.slow
def test_noise_that_came_after_a_lowpass_is_no_reason_to_call_a_simulation_wrong() -> None:
    found = diagnose(noise_after_the_lowpass(train=2, test=1, duration=10.0))
    assert found.verdict is Verdict.NOTHING_WRONG
    assert found.scores["extended"]["measured"] == pytest.approx(found.noise_floor, rel=0.05)


def test_recordings_too_short_for_a_line_in_the_band_tell_noise_by_their_first() -> None:
    """Behind a low-pass at 0.5 Hz 15 samples at 10 Hz have none: it ended in a traceback."""
    band = Band(upper=0.5, room=False)
    rng = np.random.default_rng(0)
    short = Batch(rng.standard_normal((3, 15, 2)), ("a", "b", "c"))
    assert np.isfinite(noise_of_recordings((short,), 10.0, band)).all()
    assert np.isfinite(variance_of_log_noise(15, 10.0, band))


@pytest.mark.parametrize("rate", [0.85, 10.0])
def test_noise_is_estimated_whether_or_not_modes_reach_up_to_half_the_rate(rate: float) -> None:
    """Where the fourth, at 0.34 Hz, was above the band of motion its energy counted as noise: three times as much."""
    rng, sensors = np.random.default_rng(3), tuple(Sensor(f"x{n}", n, "x", "acceleration", "m/s^2") for n in (1, 3, 4))
    begun = rng.standard_normal((2, 4, 4))
    config = FreeConfig(400.0 if rate < 1 else 60.0, rate, 0.02)
    motion = simulate_free(four_dof(), begun[0], begun[1], config, progress=False)
    clean = np.stack([motion.shown(s) for s in sensors], axis=-1)
    sigma = 0.01 * clean.std(axis=(0, 1))
    data = clean + sigma * rng.standard_normal(clean.shape)
    dataset = Dataset(four_dof(), rate, sensors, tuple(Recording(f"r{i}", part[None]) for i, part in enumerate(data)))
    band = structure_band(nominal_model_of(dataset), rate, white=True)
    estimated = noise_of_recordings(batches_of(dataset, "train"), rate, band)
    np.testing.assert_allclose(estimated, sigma, rtol=0.15)  # four recordings tell it to a twentieth
