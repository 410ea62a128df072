"""Noise that differs from recording to recording: estimated from each of them, and weighed so in fits and forecasts."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import BlindCase, BlindConfig, blind_case
from fe_models.arrays import FloatArray
from fe_models.causes.candidate import HarmonicCandidate
from fe_models.recordings import Sensor
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.fitting.linearisation import linearise_batch
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.batches import Batch, columns_of
from hybrid.diagnosis.recorded.noise import Band
from hybrid.diagnosis.recorded.noise_levels import NoiseLevels, Pattern
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.screening.force_screening import screen_forces
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose

RATE = 10.0  # Hz
BANDS = (Band(0.55, room=True), Band(4.5, room=False))
LOUD = np.exp(np.random.default_rng(2).normal(0.0, 0.5, (9, 4)))  # of each recording and channel
WAVE = np.sin(2 * np.pi * 0.3 * np.arange(501) / RATE)[None, :, None]
NAMES = tuple(f"r{number}" for number in range(9))


def white(seed: int) -> FloatArray:
    return np.random.default_rng(seed).standard_normal((9, 501, 4))


@pytest.mark.parametrize("band", BANDS, ids=["room", "no room"])
def test_recordings_with_the_same_noise_are_alike(band: Band) -> None:
    """Chance makes them differ by ten per cent; further than counts as chance in one seed of ten thousand."""
    for seed in range(3):
        batch = Batch(white(seed) + 30 * WAVE * LOUD[:, None], NAMES)
        assert NoiseLevels.of([batch], RATE, band).are_alike


@pytest.mark.parametrize("band", BANDS, ids=["room", "no room"])
@pytest.mark.parametrize("pattern", [Pattern.RECORDING, Pattern.MOTION])
def test_a_pattern_behind_the_levels_tells_them_better_than_each_recording_does(pattern: Pattern, band: Band) -> None:
    by_recording = LOUD[:, :1] * np.ones(4)
    wanted, motion = (by_recording, np.ones((9, 4))) if pattern is Pattern.RECORDING else (LOUD, LOUD)
    batch = Batch(white(0) * wanted[:, None] + 30 * WAVE * motion[:, None], NAMES)
    levels = NoiseLevels.of([batch], RATE, band)
    assert levels.pattern is pattern
    off = np.log(np.exp(levels.usual) * levels.of_recordings(batch) / wanted)
    each = 0.06 if band.room else 0.12  # by 125 frequencies above the structure's, or by the quartile of 90
    together = 2 if pattern is Pattern.RECORDING else 3  # the root of four channels; of nine recordings
    assert np.abs(off).max() < 4 * each / together


@pytest.mark.parametrize("band", BANDS, ids=["room", "no room"])
def test_a_channel_with_far_more_noise_than_its_motion_says_has_its_own(band: Band) -> None:
    """As simulated noise is a share of all motion, of which a low-pass hides what a release shakes at first."""
    wanted = LOUD.copy()
    wanted[2, 1] *= 4
    batch = Batch(white(0) * wanted[:, None] + 30 * WAVE * LOUD[:, None], NAMES)
    levels = NoiseLevels.of([batch], RATE, band)
    assert levels.pattern is Pattern.MOTION
    off = np.log(np.exp(levels.usual) * levels.of_recordings(batch) / wanted)
    each = 0.06 if band.room else 0.12  # by 125 frequencies above the structure's, or by the quartile of 90
    assert np.abs(off).max() < 4 * each


def test_no_pattern_is_behind_levels_many_of_which_it_does_not_tell() -> None:
    data = white(0) * LOUD[:, None]
    data[[2, 4, 5], :, [1, 0, 3]] *= 4  # three of 36 values
    assert NoiseLevels.of([Batch(data + 30 * WAVE * LOUD[:, None], NAMES)], RATE, BANDS[0]).are_alike


def test_one_channel_alone_tells_no_factor_of_all() -> None:
    """With one sensor a factor for each recording would fit whatever the levels are."""
    for seed in range(5):
        data = white(seed)[..., :1] + 30 * WAVE * LOUD[:, None, :1]
        data[2] *= 2
        levels = NoiseLevels.of([Batch(data, NAMES)], RATE, BANDS[0])
        assert levels.pattern is not Pattern.RECORDING


def test_motion_is_what_was_recorded_not_what_loads_leave_of_it() -> None:
    """What they leave of a recording that began at rest is all noise, in proportion to which noise always is."""
    data = white(0)
    data[2, :, 1] *= 4
    batch = Batch(data + 30 * WAVE, NAMES).less(30 * WAVE)
    assert NoiseLevels.of([batch], RATE, BANDS[1]).are_alike


def test_levels_without_a_pattern_behind_them_are_taken_for_alike() -> None:
    """One channel of one recording is rich in what is fast, as where a stop rings: that is no noise."""
    data = white(0) + 30 * WAVE * LOUD[:, None]
    data[2, :, 1] *= 4
    assert NoiseLevels.of([Batch(data, NAMES)], RATE, BANDS[1]).are_alike


def test_noise_of_recordings_of_unequal_length_is_estimated_together() -> None:
    long = Batch(white(0) + 30 * WAVE * LOUD[:, None], NAMES)
    short = Batch(3 * white(1)[:4, :200] + 30 * WAVE[:, :200], NAMES[:4])
    levels = NoiseLevels.of([long, short], RATE, BANDS[0])
    assert np.median(levels.of_recordings(short) / np.median(levels.of_recordings(long))) == pytest.approx(3, rel=0.1)


def test_a_fit_weighs_each_recording_by_its_own_noise() -> None:
    """As copies of the fit to each recording alone would: no basis, no initial state is shared that is not the same."""
    setting = setting_of(in_proportion(blind_case(3, BlindConfig(noise=0.0, train=4, test=1)), 0.03).dataset)
    (batch,) = setting.lengths.whole
    assert batch.noise is not None
    theta, noise_model = setting.nominal_hypothesis.centre, setting.noise_model
    whole = linearise_batch(setting.nominal_hypothesis, theta, batch, noise_model, None)
    assert whole is not None
    for number in range(len(batch.names)):
        alone = replace(batch.take([number]), noise=None)
        part = linearise_batch(
            setting.nominal_hypothesis,
            theta,
            alone,
            replace(noise_model, sigma=noise_model.sigma * batch.noise[number]),
            None,
        )
        assert part is not None
        np.testing.assert_allclose(whole.residual[number], part.residual[0], rtol=1e-7, atol=1e-9)
        np.testing.assert_allclose(whole.slopes[:, number], part.slopes[:, 0], rtol=1e-5, atol=1e-5)  # differences
        np.testing.assert_allclose(whole.state_errors[number], part.state_errors[0], rtol=1e-7)


def test_noise_goes_with_its_recording_and_its_channel() -> None:
    """However a batch is taken apart: each value keeps the standard deviation that is its own."""
    data = np.arange(9.0)[:, None, None] + np.zeros((9, 501, 4)) + np.array([0.0, 0.1, 0.2, 0.3])
    whole = Batch(data, NAMES, noise=data[:, 0])  # each channel of each recording is its own noise
    noise_model = NoiseModel(tuple(Sensor(f"x{i}", i, "x", "displacement", "m") for i in (2, 3)), RATE, np.ones(2))
    (pair,) = columns_of((whole,), (1, 2))
    cut = pair.cut(100)  # five segments of each
    for batch in (pair, cut, cut.take([7, 2]), pair.take([7, 2]).cut(100), pair.first(100), pair.less(0 * pair.data)):
        np.testing.assert_array_equal(batch.sigma(noise_model), batch.recorded[:, :1])
        np.testing.assert_array_equal(batch.weights(noise_model), 1 / batch.recorded.reshape(len(batch.data), -1))


def test_harmonic_forces_are_ranked_by_the_noise_of_each_recording() -> None:
    """Told of each recording, though all have it: as if it were the noise model's."""
    setting = setting_of(blind_case(104, BlindConfig(("harmonic_force",), train=3, test=1, size=0.8)).dataset)
    (batch,), noise_model = setting.lengths.whole, setting.noise_model
    forces = tuple(c for c in setting.candidates() if isinstance(c, HarmonicCandidate))
    times = np.array([1.0, 3.0, 0.5, 1.0])
    own = replace(batch, noise=np.tile(times, (3, 1))), noise_model
    usual = batch, replace(noise_model, sigma=times * noise_model.sigma)
    promised = []
    for recorded, measured_with in (own, usual):
        found = fit(setting.nominal_hypothesis, setting.nominal_hypothesis.centre, (recorded,), measured_with)
        assert found is not None
        promised.append(screen_forces(found, forces, measured_with))
    for by_recording, by_gauge in zip(*promised, strict=True):
        assert (by_recording.candidate.key, by_recording.start) == (by_gauge.candidate.key, by_gauge.start)
        assert by_recording.gain == pytest.approx(by_gauge.gain, rel=1e-6)  # rounding, in a difference of sums


def test_what_a_fit_leaves_is_noise_of_one_in_every_recording() -> None:
    setting = setting_of(in_proportion(blind_case(3, BlindConfig(noise=0.0)), 0.03).dataset)
    found = fit(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths.whole, setting.noise_model
    )
    assert found is not None
    left = np.concatenate([part.std(axis=1) for part in found.residuals])  # (recording, sensor)
    assert left == pytest.approx(np.ones_like(left), rel=0.1)  # by 1/sqrt(1000) each, 36 of them
    assert np.log(left).std() < 0.04


def in_proportion(case: BlindCase, share: float) -> BlindCase:
    """Give each channel of each recording noise in proportion to its own motion; three lie still, three are tossed."""
    rng, recordings = np.random.default_rng(7), []
    for number, recording in enumerate(case.dataset.recordings):
        data = recording.data * (0.3, 1.0, 3.0)[number % 3]
        noise = share * data.std(axis=-2, keepdims=True) * rng.standard_normal(data.shape)
        recordings.append(replace(recording, data=data + noise))
    return replace(case, dataset=replace(case.dataset, recordings=tuple(recordings)))


def diagnosed(seed: int, *kinds: str) -> Diagnosis:
    """The test recording is tossed: it has three times the usual noise."""
    config = BlindConfig(kinds, noise=0.0, train=5, test=1, duration=30.0, tier="off", size=0.8)
    return diagnose(in_proportion(blind_case(seed, config), 0.03).dataset)


def test_a_test_recording_with_more_noise_is_no_reason_to_call_a_simulation_wrong() -> None:
    found = diagnosed(120)
    assert found.verdict is Verdict.NOTHING_WRONG
    assert found.scores["extended"]["measured"] == pytest.approx(found.noise_floor, rel=0.05)


@pytest.mark.slow
def test_a_cause_is_named_in_recordings_with_unlike_noise() -> None:
    found = diagnosed(101, "added_mass")
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert finding.cause.kind == "added_mass"
    assert any(note.startswith("noise goes with each channel's own motion") for note in found.notes)
    assert found.scores["extended"]["measured"] == pytest.approx(found.noise_floor, rel=0.05)


def test_uneven_noise_is_a_share_of_each_recordings_own_motion() -> None:
    noisy, clean = (blind_case(3, BlindConfig(noise=noise, noisy="uneven")).dataset.recordings for noise in (0.05, 0.0))
    shares = [(a.data - b.data).std(axis=1) / b.data.std(axis=1) for a, b in zip(noisy, clean, strict=True)]
    assert np.stack(shares) == pytest.approx(np.full((12, 1, 5), 0.05), rel=0.15)  # of 501 values each: 3 %
