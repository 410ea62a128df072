"""Up to which frequency recordings show a frame's motions: a low-pass hides what is fast, unless it is large."""

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from benchmarks.blind_cases.bridge import SENSORS
from fe_models.arrays import FloatArray
from fe_models.built_in.bridge import bridge
from fe_models.measurement import lowpassed
from fe_models.recordings import Dataset, Load, Recording
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.nominal.lowpass import highest_shown, lowpass_of
from hybrid.diagnosis.nominal.structure_model import nominal_model_of

RATE, SAMPLES, CUTOFF, NOISE = 100.0, 2000, 30.0, 0.03
FITTED = tuple(sensor for sensor in SENSORS if sensor.role == "measured")
TIME = np.arange(SAMPLES) / RATE
USUAL = 30.0 * 4.0**0.125  # Hz, where 1 / (1 + (f / 30 Hz)^8) is 0.2


def dataset(channel: FloatArray, role: Literal["train", "test"] = "train", sharply: bool = False) -> Dataset:
    """Return recordings of which all sensors feel a mode at 6.4 Hz, and the first of the second ``channel`` instead.

    ``sharply``: what lies a fiftieth above the low-pass is taken out wholly, noise and all; else the noise is white.
    """
    data = np.tile(np.sin(2 * np.pi * 6.4 * TIME)[:, None], (1, len(FITTED)))
    data[:, 0] = channel
    data += NOISE * data.std(axis=0) * np.random.default_rng(0).standard_normal(data.shape)
    if sharply:
        spectrum = np.fft.rfft(data, axis=0)
        spectrum[np.fft.rfftfreq(SAMPLES, 1 / RATE) > 1.02 * CUTOFF] = 0
        data = np.fft.irfft(spectrum, SAMPLES, axis=0)
    calm = Recording("calm", data[None, :, 1:2].repeat(len(FITTED), axis=2))
    return Dataset(bridge(), RATE, FITTED, (calm, Recording("fast", data[None], role)), CUTOFF)


def two_modes(amplitude: float) -> FloatArray:
    """Return a decaying motion at 6.4 Hz with one at 38.8 Hz, the thirteenth mode, beside it."""
    return np.exp(-TIME / 3) * (np.sin(2 * np.pi * 6.4 * TIME) + amplitude * np.sin(2 * np.pi * 38.8 * TIME))


@pytest.mark.parametrize(("amplitude", "highest"), [(0.0, USUAL), (0.1, RATE / 2)])
def test_a_mode_beyond_the_lowpass_is_followed_where_it_is_larger_than_noise(amplitude: float, highest: float) -> None:
    data = dataset(two_modes(amplitude))
    assert highest_shown(data, lowpass_of(data)) == pytest.approx(highest, rel=1e-12)
    nominal = nominal_model_of(data)
    # as the bridge has
    assert np.sum(nominal.modes[0] < 2 * np.pi * highest) == nominal.size == (14 if amplitude else 11)


@pytest.mark.parametrize(("ringing", "highest"), [(0.01, USUAL), (0.08, RATE / 2)])
def test_a_mode_beyond_the_lowpass_is_followed_where_it_rings_for_a_moment(ringing: float, highest: float) -> None:
    """In half a second it holds too little energy to be seen among that of 20 s, and more than noise then."""
    data = dataset(two_modes(0.0) + ringing * np.exp(-TIME / 0.5) * np.sin(2 * np.pi * 38.8 * TIME))
    assert highest_shown(data, lowpass_of(data)) == pytest.approx(highest, rel=1e-12)


def test_modes_beyond_the_lowpass_are_followed_where_a_load_keeps_them_ringing() -> None:
    data = dataset(two_modes(0.0))
    loads = (Load(8, "y", np.zeros(SAMPLES)),)
    loaded = replace(data, recordings=(data.recordings[0], replace(data.recordings[1], loads=loads)))
    assert highest_shown(loaded, lowpass_of(loaded)) == RATE / 2


def test_what_only_a_test_recording_shows_is_not_looked_at() -> None:
    data = dataset(two_modes(0.1), role="test")
    assert highest_shown(data, lowpass_of(data)) == pytest.approx(USUAL, rel=1e-12)


def test_a_mode_at_the_end_of_a_sharp_lowpass_is_no_motion_beyond_it() -> None:
    wave = np.sin(2 * np.pi * 30.5 * TIME)  # a line of its spectrum is 0.8 Hz wide, and 20 % pass at 30.66 Hz
    data = dataset(wave, sharply=True)
    assert lowpass_of(data).reach(0.2) < 31.0  # type: ignore[union-attr]
    assert highest_shown(data, lowpass_of(data)) < 31.0


def test_noise_that_was_low_passed_with_the_motion_shows_nothing() -> None:
    noise = lowpassed(np.random.default_rng(1).standard_normal((SAMPLES, 1)), RATE, CUTOFF)[:, 0]
    data = dataset(two_modes(0.0) + 0.1 * noise)  # a third of the motion: white, it would be far more than `FAINT`
    assert highest_shown(data, lowpass_of(data)) == pytest.approx(USUAL, rel=1e-12)


def test_recordings_without_a_lowpass_show_all_up_to_half_their_rate() -> None:
    data = dataset(two_modes(0.0))
    assert highest_shown(data, None) == RATE / 2


@pytest.mark.slow
def test_samples_that_are_not_used_show_nothing() -> None:
    """A saturated channel has steps in it, which are fast."""
    data = dataset(two_modes(0.0))
    fast = data.recordings[1].data.copy()
    fast[:, : SAMPLES // 4, 0] = np.sign(fast[:, : SAMPLES // 4, 0]) * 2 * np.abs(fast[..., 0]).max()
    spoilt = replace(data, recordings=(data.recordings[0], replace(data.recordings[1], data=fast)))
    assert highest_shown(spoilt, lowpass_of(spoilt)) == RATE / 2
    setting = setting_of(spoilt)
    assert any("is saturated" in note for note in setting.notes)
    assert setting.nominal.highest == pytest.approx(USUAL, rel=1e-12)
