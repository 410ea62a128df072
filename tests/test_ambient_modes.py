"""Modes out of recordings alone, under unknown random forces: true values, true standard deviations, nothing else."""

import numpy as np
import pytest

from benchmarks.shear_frame import RATIO, ambient, frame_modes, frame_recording, with_noise
from fe_models.arrays import ComplexArray, FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.files.bridge_recordings import bridge_sensors
from fe_models.linear import ModalModel
from fe_models.modes import mac, natural_modes
from hybrid.identification.ambient_modes import identify_ambient_modes
from hybrid.identification.covariance_subspace import CovarianceSubspace, PolesOfOrder
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.output_correlations import Correlations, correlations_of

FRAME = frame_modes()
RATE, SAMPLES = 20.0, 14400


def identified(data: FloatArray, rate: float = RATE, first: float = float(FRAME.frequencies[0])) -> IdentifiedModes:
    return identify_ambient_modes([data], rate, first, rate / 2).modes


def least_deviations(modal: ModalModel, seconds: float) -> tuple[FloatArray, FloatArray]:
    """Standard deviations of natural frequencies, relative, and of damping ratios that no estimate stays below.

    xi / (2 pi f T), root, of a mode alone in white noise; of damping 1 / (2 pi xi f T), root, relative (Au, Mech. Syst.
    Signal Process. 48, 2014).
    """
    cycles = 2 * np.pi * modal.frequencies * seconds
    return np.sqrt(modal.damping_ratio / cycles), np.sqrt(modal.damping_ratio / cycles)


def test_correlations_are_means_over_samples() -> None:
    rng = np.random.default_rng(0)
    parts = [rng.standard_normal((200, 2)), rng.standard_normal((91, 2))]
    found = correlations_of(parts, 10, 27)
    assert found.parts.shape[1:] == (11, 2, 2)
    used = [190, 80]  # whole segments of 10 samples
    for lag in (0, 3, 10):
        expected = sum(y[lag : lag + n].T @ y[:n] for y, n in zip(parts, used, strict=True)) / sum(used)
        np.testing.assert_allclose(found.mean[lag], expected, atol=1e-12)
    np.testing.assert_allclose(found.parts.sum(axis=0), 0, atol=1e-12)


def test_influence_is_the_slope_of_poles_and_shapes() -> None:
    """Exact correlations of one mode at three sensors, and another direction in which they move: by differences."""
    rng = np.random.default_rng(1)
    pole, shape, g = np.exp(complex(-0.02, 0.5)), np.array([1.0, -0.5, 0.3]), np.array([0.4, 1.0, -0.2 + 0.3j])
    lags = np.arange(9)
    exact = np.real(pole ** lags[:, None, None] * (shape[:, None] * g))
    exact[0] = 2 * np.eye(3)
    # what a pole of another decay and frequency, and other shapes, would add, to first order: the rank stays two
    step = 1e-6
    moved = np.real((pole * (1 + 3e-3j)) ** lags[:, None, None] * (shape + 0.01 * rng.standard_normal(3))[:, None] * g)
    direction = moved - np.real(pole ** lags[:, None, None] * (shape[:, None] * g))
    direction[0] = 0
    before, after = (
        CovarianceSubspace.of(Correlations(exact + sign * step * direction, direction[None])).poles(2)
        for sign in (-1, 1)
    )
    subspace = CovarianceSubspace.of(Correlations(exact, direction[None]))
    poles = subspace.poles(2)
    number = int(np.argmax(poles.values.imag))
    influence = subspace.influence(poles, number)[0]

    (first, early), (last, late) = (_upper(found) for found in (before, after))
    np.testing.assert_allclose(influence[0], (last - first) / (2 * step), rtol=1e-4)
    z = poles.shapes[number] / poles.shapes[number, 0]
    by_entry = (influence[1:] - z * influence[1]) / poles.shapes[number, 0]
    np.testing.assert_allclose(by_entry, (late - early) / (2 * step), atol=1e-4 * np.abs(by_entry).max())


def _upper(poles: PolesOfOrder) -> tuple[complex, ComplexArray]:
    """Return the pole above the real axis and its shape, one at the first sensor."""
    number = int(np.argmax(poles.values.imag))
    return complex(poles.values[number]), poles.shapes[number] / poles.shapes[number, 0]


def test_one_mode_is_known_as_well_as_can_be() -> None:
    """One mass, one sensor: its frequency and damping, and standard deviations near those that no estimate beats."""
    one = ModalModel(FRAME.omega[:1], FRAME.damping_ratio[:1], FRAME.shapes[:, :1], FRAME.dofs)
    row = FRAME.dofs.row(1, "x")
    least, least_ratio = least_deviations(one, SAMPLES / RATE)
    pulls, said = [], []
    for seed in range(20):
        found = identified(ambient(one, [row], [row], SAMPLES, RATE, np.random.default_rng(seed)))
        assert len(found.roots) == 1
        errors = np.array([found.frequency_errors[0] / found.frequencies[0], found.ratio_errors[0]])
        off = np.array([found.frequencies[0] / one.frequencies[0] - 1, found.ratios[0] - RATIO])
        pulls.append(off / errors)
        said.append(errors / [least[0], least_ratio[0]])
    # the scatter of 20 is known to 16 %; three of these
    assert np.all(np.abs(np.std(pulls, axis=0) - 1) < 0.5)
    # first order, and no more than lags of 1.5 periods: within 40 % of what is possible, on average
    assert np.all((np.mean(said, axis=0) > 0.9) & (np.mean(said, axis=0) < 1.4))


def off_the_frame(found: IdentifiedModes) -> FloatArray:
    """Errors of frequencies, relative, and damping ratios over their standard deviations (2, mode)."""
    assert len(found.roots) == 5, found.frequencies
    rows = [FRAME.dofs.row(node, "x") for node in range(1, 6)]
    assert np.diag(mac(FRAME.shapes[rows], found.shapes)).min() > 0.99
    frequencies = (found.frequencies - FRAME.frequencies) / found.frequency_errors
    return np.array([frequencies, (found.ratios - RATIO) / found.ratio_errors])


@pytest.mark.parametrize("noise", [0.0, 0.03])
def test_a_shear_frame_shows_its_five_modes_and_no_other(noise: float) -> None:
    """Twelve minutes: the lowest mode's frequency cannot be known better than to 0.22 %, its damping to 11 %."""
    for seed in range(5):
        found = identified(frame_recording(seed, noise=noise))
        assert np.abs(off_the_frame(found)).max() < 4.5  # of 50 numbers whose deviations are themselves estimated
        np.testing.assert_allclose(found.frequencies, FRAME.frequencies, rtol=0.01)
        np.testing.assert_allclose(found.ratios, RATIO, rtol=0.45)  # four standard deviations of the lowest mode's
        assert found.left < 0.3  # forces move an accelerometer at all frequencies


@pytest.mark.slow
def test_stated_standard_deviations_are_those_of_many_recordings() -> None:
    modes = [identified(frame_recording(seed)) for seed in range(50)]
    pulls = np.array([off_the_frame(found) for found in modes])
    spread = pulls.std(axis=(0, 2))
    assert np.all((spread > 0.8) & (spread < 1.25))  # 250 pulls: known to 5 %, beside what modes have in common
    assert np.abs(pulls.mean(axis=(0, 2))).max() < 0.4  # little bias beside the scatter
    frequencies = np.array([found.frequencies for found in modes])
    ratios = np.array([found.ratios for found in modes])
    assert np.mean(np.abs(frequencies / FRAME.frequencies - 1) < 0.005) > 0.97  # of the lowest mode 0.3 % is one sigma
    assert np.mean(np.abs(ratios / RATIO - 1) < 0.2) > 0.93  # 14 %
    # shapes: the entries' errors over their standard deviations, but for those of the reference
    rows = [FRAME.dofs.row(node, "x") for node in range(1, 6)]
    off = []
    for found in modes:
        true = FRAME.shapes[rows] / FRAME.shapes[rows][found.reference, np.arange(5)]
        deviation = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2)[:, 2:7])
        other = np.arange(5) != found.reference[:, None]
        off.append((found.shapes.real - true).T[other] / deviation[other])
    assert 0.8 < np.std(np.concatenate(off)) < 1.25


def test_noise_alone_shows_no_mode() -> None:
    for seed in range(5):
        found = identified(np.random.default_rng(seed).standard_normal((SAMPLES, 5)))
        assert len(found.roots) == 0
        assert found.left == 1.0


def test_modes_one_per_cent_apart_are_two() -> None:
    """A tower that is nearly alike in two directions: shapes at right angles, frequencies 1 % apart, damping 1 %."""
    rows = [FRAME.dofs.row(node, "x") for node in range(1, 5)]
    shapes = np.zeros((len(FRAME.shapes), 2))
    shapes[rows] = [[1.0, 0.2], [0.6, 0.1], [-0.2, 1.0], [-0.1, 0.6]]
    pair = ModalModel(2 * np.pi * np.array([2.0, 2.02]), np.full(2, 0.01), shapes, FRAME.dofs)
    for seed in range(3):
        rng = np.random.default_rng(seed)
        found = identified(with_noise(ambient(pair, rows, rows, SAMPLES, RATE, rng), 0.03, rng), first=2.0)
        assert len(found.roots) == 2
        assert np.abs((found.frequencies - [2.0, 2.02]) / found.frequency_errors).max() < 4
        assert np.diag(mac(shapes[rows], found.shapes)).min() > 0.97  # they lie within each other's peak


def test_a_faster_recorder_and_drift_change_nothing() -> None:
    data = frame_recording(3)
    drift = 5 * data.std() * np.linspace(-1, 1, SAMPLES)[:, None]
    plain, drifting = identified(data), identified(data + drift + 7.0)
    np.testing.assert_allclose(drifting.frequencies, plain.frequencies, rtol=1e-6)
    low = identify_ambient_modes([frame_recording(3, 6 * SAMPLES, 6 * RATE)], 6 * RATE, 0.9, RATE / 2).modes
    assert np.abs(off_the_frame(low)).max() < 4.5


def test_several_motions_of_one_state_count_together() -> None:
    found = identify_ambient_modes([frame_recording(seed) for seed in range(3)], RATE, 0.9, RATE / 2).modes
    alone = identified(frame_recording(0))
    np.testing.assert_allclose(found.frequency_errors / alone.frequency_errors, 1 / np.sqrt(3), rtol=0.5)
    off_the_frame(found)


def test_a_dead_channel_and_a_recording_too_short_show_what_is_left() -> None:
    data = frame_recording(1)
    data[:, 2] = 0.0
    assert len(identified(data).roots) == 5
    assert len(identified(data[:10]).roots) == 0


def test_one_force_without_noise_is_enough() -> None:
    """As a simulation gives it: five channels that one force moves hold less than five would."""
    rows = [FRAME.dofs.row(node, "x") for node in range(1, 6)]
    for seed in range(3):
        found = identified(ambient(FRAME, rows, rows[:1], 6000, RATE, np.random.default_rng(seed)))
        assert len(found.roots) == 5
        assert np.abs((found.frequencies - FRAME.frequencies) / found.frequency_errors).max() < 4.5
        assert np.all(found.frequency_errors < 0.015 * found.frequencies)
        # what is called noise so that an inverse exists, 7 % of the rms, takes its part of the weakest shape
        assert np.diag(mac(FRAME.shapes[rows], found.shapes)).min() > 0.95


def test_gusts_are_no_modes() -> None:
    """Forces that are ten times as large in one minute as in another: fewer samples count than there are."""
    extra = 0
    for seed in range(6):
        rng = np.random.default_rng(seed)
        gusts = np.exp(np.interp(np.arange(SAMPLES), np.arange(0, SAMPLES, 1200), rng.standard_normal(12)))
        found = identified(frame_recording(seed) * gusts[:, None])
        away = np.abs(found.frequencies[:, None] / FRAME.frequencies - 1).min(axis=1)
        extra += int(np.sum(away > 0.03))
        assert len(found.roots) >= 3
    assert extra <= 1


@pytest.mark.slow
def test_a_slow_tower_is_seen_by_a_fast_recorder() -> None:
    """0.15 Hz at 100 Hz: the lowest mode's period has 670 samples, more than there can be block rows."""
    slow = ModalModel(FRAME.omega * 0.15 / FRAME.frequencies[0], np.full(5, 0.01), FRAME.shapes, FRAME.dofs)
    rows = [FRAME.dofs.row(node, "x") for node in range(1, 6)]
    rng = np.random.default_rng(0)
    data = with_noise(ambient(slow, rows, rows, 120_000, 100.0, rng), 0.03, rng)
    found = identify_ambient_modes([data], 100.0, 0.15, 50.0)
    assert len(found.modes.roots) == 5
    assert np.abs((found.modes.frequencies - slow.frequencies) / found.modes.frequency_errors).max() < 4
    assert found.modes.energy.sum() < 0.5  # a white force moves accelerometers far above the modes
    kept = found.stabilisation.modes[0]
    assert all(np.min(np.abs(np.abs(kept) / root - 1)) < 0.01 for root in np.abs(found.modes.roots))


@pytest.mark.slow
def test_the_bridge_under_wind_shows_every_mode_of_its_band_and_no_other() -> None:
    """Ten minutes, coloured forces on deck and towers, seven accelerometers with 3 % of noise, filtered at 30 Hz."""
    model = linearise(bridge())
    modal = natural_modes(model, 12)  # up to 37 Hz
    sensors = [sensor for sensor in bridge_sensors() if sensor.role == "measured"]
    rows = [model.dofs.row(sensor.node, str(sensor.direction)) for sensor in sensors]
    forced = [model.dofs.row(node, "y") for node in (2, 3, 5, 9, 11, 13, 15, 17, 19, 21, 25, 28)]
    forced += [model.dofs.row(node, "x") for node in (34, 37, 40, 42, 47, 50, 53, 55)]
    for seed in range(2):
        rng = np.random.default_rng(seed)
        data = with_noise(ambient(modal, rows, forced, 60_000, 100.0, rng, corner=5.0), 0.03, rng)
        found = identify_ambient_modes([data], 100.0, float(modal.frequencies[0]), 30.0).modes
        assert len(found.roots) == 10
        off = (found.frequencies - modal.frequencies[:10]) / found.frequency_errors
        assert np.abs(off).max() < 4.5
        assert np.diag(mac(modal.shapes[rows, :10], found.shapes)).min() > 0.98
