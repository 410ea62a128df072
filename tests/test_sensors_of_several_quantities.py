"""Displacements, velocities and accelerations beside one another: a velocity is a quarter of a period ahead."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.shear_frame import frame_modes, frame_recording
from fe_models.arrays import FloatArray, IntArray
from hybrid.identification.agreement import shares_unexplained, window_of
from hybrid.identification.backbone import backbone_of
from hybrid.identification.identification import identify
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.pairing import displacements_of
from tests.hybrid_problems import HELD_OUT, chain_dataset, chain_modes

RATE, SAMPLES = 100.0, 2000
ROOTS = 2 * np.pi * np.array([3.9, 6.3]) * (-0.004 + 1j * np.sqrt(1 - 0.004**2))
SHAPES = np.array([[1.0, 0.8, -0.5], [-0.6, 1.0, 0.9]])  # (mode, sensor)
ORDERS = np.array([0, 1, 2])


def motion(orders: IntArray, begin: tuple[complex, complex] = (1.0, 0.6j), noise: float = 1e-3) -> FloatArray:
    """Return the closed form of a free decay, (time, sensor), as sensors of such orders show it, with noise."""
    waves = np.exp(np.outer(np.arange(SAMPLES) / RATE, ROOTS)) * begin
    clean = np.real(np.einsum("tm,ms,ms->ts", waves, SHAPES, ROOTS[:, None] ** orders))
    return np.asarray(clean + noise * clean.std(axis=0) * np.random.default_rng(0).standard_normal(clean.shape))


def modes_of(data: FloatArray, orders: IntArray) -> IdentifiedModes:
    return identify([data], RATE, 3.9, 30.0, orders, "free").modes


@pytest.mark.parametrize("orders", [[0, 1, 2], [1, 1, 2], [1, 1, 1], [0, 2, 1]])
def test_shapes_of_displacements_come_back(orders: list[int]) -> None:
    found = modes_of(motion(np.array(orders)), np.array(orders))
    np.testing.assert_allclose(found.frequencies, np.abs(ROOTS) / (2 * np.pi), rtol=1e-4)
    expected = SHAPES / SHAPES[[0, 1], np.argmax(np.abs(SHAPES), axis=1)][:, None]
    np.testing.assert_allclose(displacements_of(found).T, expected, atol=0.01)  # a hundredth of noise over 2000 samples
    assert found.collinearity.min() > 0.999


def test_the_modes_of_one_motion_explain_another() -> None:
    data = [motion(ORDERS), motion(ORDERS, (0.2j, 1.0))]
    found = [modes_of(each, ORDERS) for each in data]
    window = window_of(found, [SAMPLES / RATE] * 2)
    left = shares_unexplained(found, data, [RATE] * 2, window)
    assert left.max() < 1e-4  # the noise has a millionth of the power
    wrong = [replace(own, orders=np.zeros(3, dtype=int)) for own in found]
    assert shares_unexplained(wrong, data, [RATE] * 2, window).min() > 0.1


def test_amplitudes_while_the_motion_decays_are_those_of_the_largest_entry() -> None:
    data = motion(ORDERS)
    curve = backbone_of(data, modes_of(data, ORDERS), 0, RATE)
    # the acceleration is the largest in numbers: half of the squared angular frequency at the beginning
    span = 2 * (np.log(0.5 * abs(ROOTS[0]) ** 2) - np.log(curve.amplitude[0])) / -ROOTS[0].real
    np.testing.assert_allclose(span, 12 / 3.9, rtol=0.05)  # s: amplitudes are those in the middle of twelve periods


def test_energies_are_those_of_all_quantities_together() -> None:
    together, moved, accelerated = (modes_of(motion(own), own) for own in (ORDERS, 0 * ORDERS, 0 * ORDERS + 2))
    assert moved.energy[0] - 0.03 > together.energy[0] > accelerated.energy[0] + 0.03
    np.testing.assert_allclose(together.energy.sum() + together.left, 1, atol=0.01)  # two modes hardly overlap
    sizes = together.sizes / together.sizes[0]
    between = np.abs(ROOTS)[:, None] ** ORDERS
    assert np.all((between[0] <= sizes) & (sizes <= between[1]))


def test_a_sensor_at_which_nothing_moves_counts_as_little_as_its_noise() -> None:
    data, orders = motion(ORDERS), np.array([0, 1, 2, 0])
    still = 1e-4 * np.random.default_rng(1).standard_normal((SAMPLES, 1))  # m, beside a motion of one
    assert modes_of(np.hstack([data, still]), orders).left < 1e-3


def test_a_noisy_accelerometer_leaves_displacements_their_say() -> None:
    orders = np.array([0, 0, 2])
    data = motion(orders)
    data[:, 2] += 1.5 * data[:, 2].std() * np.random.default_rng(1).standard_normal(SAMPLES)
    found = modes_of(data, orders)
    curve = backbone_of(data, found, 0, RATE)
    assert len(curve.frequency) > 5  # none, if channels in their own units were added up
    assert curve.deviation.max() < 1e-4  # Hz
    assert np.all(np.abs(curve.frequency - 3.9) < 4 * curve.deviation + 1e-4)


def test_what_sensors_show_at_rest_is_no_motion() -> None:
    data = [motion(ORDERS), motion(ORDERS, (0.2j, 1.0))]
    found = [modes_of(each, ORDERS) for each in data]
    window = window_of(found, [SAMPLES / RATE] * 2)
    left = shares_unexplained(found, data, [RATE] * 2, window)
    offset = shares_unexplained(found, [each + np.array([1.0, -10.0, 1e3]) for each in data], [RATE] * 2, window)
    np.testing.assert_allclose(offset, left, atol=1e-9)


def test_ambient_vibration_is_identified_as_well() -> None:
    """One of the accelerometers of a frame integrated over time to a velocity, a line for each frequency."""
    data, rate, first = frame_recording(0, 20_000), 20.0, float(frame_modes().frequencies[0])
    lines = 2j * np.pi * np.fft.rfftfreq(len(data), 1 / rate)
    lines[0] = np.inf
    data[:, 1] = np.fft.irfft(np.fft.rfft(data[:, 1]) / lines, len(data))
    orders = np.array([2, 1, 2, 2, 2])
    found = identify([data], rate, first, 10.0, orders, "ambient").modes
    alike = identify([frame_recording(0, 20_000)], rate, first, 10.0, np.full(5, 2), "ambient").modes
    assert len(found.roots) == len(alike.roots) >= 4
    # the integral has other noise and other weights of lines, no other structure
    np.testing.assert_allclose(displacements_of(found), displacements_of(alike), atol=0.1)
    several = identify([data], rate, first, 10.0, orders, None)
    assert several.is_ambient
    np.testing.assert_allclose(several.modes.energy, found.energy)


def test_a_chain_with_a_velocity_among_its_sensors_shows_all_its_modes() -> None:
    dataset = chain_dataset(chain_modes(), noise=0.005, realisations=1, samples=1000)
    orders = np.array([0, 2, 1, 2, 2])
    assert dataset.sensors[HELD_OUT].quantity == "velocity"
    for recording in dataset.recordings:
        found = identify(list(recording.data), dataset.rate_of(recording), 0.039, 1.0, orders).modes
        np.testing.assert_allclose(found.frequencies, chain_modes().frequencies, rtol=1e-3)
        taken_for_one = identify(list(recording.data), dataset.rate_of(recording), 0.039, 1.0, 0 * orders).modes
        assert len(taken_for_one.roots) < 4  # out of phase, as noise is
