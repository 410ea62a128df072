"""Lines of machines are told from modes, with their frequencies and amplitudes; modes are told for none."""

import numpy as np
import pytest

from benchmarks.shear_frame import frame_modes, frame_recording
from fe_models.arrays import FloatArray
from hybrid.identification.ambient_modes import AmbientModes, identify_ambient_modes
from hybrid.identification.narrow_band import amplitude_of

RATE, SAMPLES = 20.0, 14400
FRAME = frame_modes()
TIME = np.arange(SAMPLES) / RATE
SHARES = np.array([1.0, 0.5, 0.2, -0.3, 0.4])


def identified(data: FloatArray) -> AmbientModes:
    return identify_ambient_modes([data], RATE, float(FRAME.frequencies[0]), RATE / 2)


def test_a_narrow_band_holds_a_sine_and_no_neighbour() -> None:
    wave = 3 * np.cos(2 * np.pi * 2.01 * TIME + 0.4) + 2 * np.cos(2 * np.pi * 2.6 * TIME)
    amplitude = np.abs(amplitude_of(wave[:, None], RATE, 2.01, 0.5))[20:-20]
    np.testing.assert_allclose(amplitude, 3.0, rtol=1e-3)  # less what rings from the ends
    assert len(amplitude) < SAMPLES / 20  # no more samples than the band asks for


@pytest.mark.parametrize(("frequency", "size"), [(3.3, 0.1), (2.61, 0.5), (5.0, 1.0)])
def test_a_line_is_told_from_modes(frequency: float, size: float) -> None:
    """Between modes, within the peak of one, and as strong as all the rest together."""
    for seed in range(3):
        data = frame_recording(seed)
        amplitude = size * data[:, 0].std() * SHARES
        found = identified(data + np.cos(2 * np.pi * frequency * TIME + seed)[:, None] * amplitude)
        (line,) = found.harmonics
        assert line.frequency == pytest.approx(frequency, abs=0.5 / 720)  # half of what 720 s tell apart
        # what the modes have in that line adds to it: a sixth of the weakest sine, in the peak of one
        np.testing.assert_allclose(line.amplitude, np.abs(amplitude), atol=0.25 * amplitude[0])
        assert len(found.modes.roots) == 5
        np.testing.assert_allclose(found.modes.frequencies, FRAME.frequencies, rtol=0.01)


def test_a_machine_whose_speed_wanders_is_one() -> None:
    """By 0.1 %, in half a minute: no single line of the spectrum any more, and an amplitude that stays."""
    rng = np.random.default_rng(5)
    speed = np.interp(TIME, TIME[::600], rng.standard_normal(len(TIME[::600])))
    phase = 2 * np.pi * 3.3 * np.cumsum(1 + 1e-3 * speed) / RATE
    data = frame_recording(1)
    found = identified(data + 0.5 * data.std() * np.cos(phase)[:, None] * SHARES)
    (line,) = found.harmonics
    assert line.frequency == pytest.approx(3.3, rel=3e-3)
    assert len(found.modes.roots) == 5


def test_modes_are_taken_for_no_lines() -> None:
    for seed in range(10):
        assert identified(frame_recording(seed, 6000)).harmonics == ()
