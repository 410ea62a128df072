"""Modes of free decays are as uncertain as they say: scatter over many recordings, closely spaced ones, no noise."""

import numpy as np
import pytest

from fe_models.arrays import ComplexArray, FloatArray
from hybrid.identification.free_decay_modes import identify_modes
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.stabilisation import stabilisation_of

RATE, SAMPLES = 50.0, 600
RATIOS = np.array([0.006, 0.004])
ROOTS = 2 * np.pi * np.array([3.9, 6.3]) * (-RATIOS + 1j * np.sqrt(1 - RATIOS**2))
SHAPES = np.array([[1.0, 0.5 + 0.05j, -0.2], [-0.3, 1.0, 0.6 - 0.1j]])  # (mode, sensor): not quite in phase
NOISE = np.array([0.02, 0.05, 0.03])


def decay(amplitudes: ComplexArray, roots: ComplexArray = ROOTS, shapes: ComplexArray = SHAPES) -> FloatArray:
    """Return the free decay (time, sensor) of modes with these amplitudes."""
    waves = np.exp(np.outer(np.arange(SAMPLES) / RATE, roots))
    return np.asarray(np.real((waves * amplitudes) @ shapes))


def drawn(motions: int, rng: np.random.Generator) -> list[FloatArray]:
    """Return noisy motions of the two modes."""
    sizes = [np.array([1.0, 0.6]) * np.exp(2j * np.pi * rng.uniform(size=2)) for _ in range(motions)]
    return [decay(size) + NOISE * rng.standard_normal((SAMPLES, 3)) for size in sizes]


def pulls(found: IdentifiedModes) -> FloatArray:
    """Return how far frequencies, ratios and free entries of shapes are off, in their standard deviations."""
    assert len(found.roots) == 2
    truth = SHAPES / np.take_along_axis(SHAPES, found.reference[:, None], axis=1)
    off = found.shapes.T - truth
    errors = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2)[:, 2:]).reshape(2, 2, 3)
    free = np.arange(3) != found.reference[:, None]
    return np.concatenate(
        [
            (found.frequencies - np.abs(ROOTS) / (2 * np.pi)) / found.frequency_errors,
            (found.ratios - RATIOS) / found.ratio_errors,
            (off.real[free] / errors[:, 0][free]),
            (off.imag[free] / errors[:, 1][free]),
        ]
    )


@pytest.mark.slow
@pytest.mark.parametrize("motions", [1, 3])
def test_errors_scatter_as_their_standard_deviations_say(motions: int) -> None:
    rng = np.random.default_rng(motions)
    found = np.array([pulls(identify_modes(drawn(motions, rng), RATE, 3.9, 20.0)) for _ in range(20)])
    # 240 pulls, some of them correlated: their rms is known to 5 to 10 %; the noise about a mode, to a tenth, adds some
    assert np.sqrt(np.mean(found**2)) == pytest.approx(1.0, abs=0.25)
    assert np.mean(np.abs(found) > 3) < 0.02


def test_more_motions_are_surer() -> None:
    rng = np.random.default_rng(5)
    one, four = (identify_modes(drawn(count, rng), RATE, 3.9, 20.0) for count in (1, 4))
    ratio = one.frequency_errors / four.frequency_errors
    # twice, as the root of four; the noise about a mode is known of nine lines, to a fifth, in the one motion
    np.testing.assert_allclose(ratio, 2.0, rtol=0.5)


def test_closely_spaced_modes_of_other_shapes_are_two() -> None:
    """1 % apart, at 12 s of recording: a tenth of a hertz in lines of 0.08 Hz."""
    near = ROOTS.copy()
    near[1] = 1.01 * near[0]
    data = decay(np.array([1.0, 0.8]), roots=near) + NOISE * np.random.default_rng(7).standard_normal((SAMPLES, 3))
    found = identify_modes(data, RATE, 3.9, 20.0)
    np.testing.assert_allclose(np.abs(found.roots), np.abs(near), rtol=2e-3)
    assert len(found.roots) == 2


def test_recordings_without_noise_give_the_modes_exactly() -> None:
    found = identify_modes(decay(np.array([1.0, 0.6j])), RATE, 3.9, 20.0)
    np.testing.assert_allclose(found.roots, ROOTS, rtol=1e-7)  # where the search for least squares ends
    assert np.isfinite(found.covariance).all()


def test_nothing_that_vibrates_has_no_modes() -> None:
    found = identify_modes(NOISE * np.random.default_rng(8).standard_normal((SAMPLES, 3)), RATE, 3.9, 20.0)
    assert len(found.roots) == 0


def test_poles_of_modes_stay_from_order_to_order() -> None:
    found = stabilisation_of(drawn(1, np.random.default_rng(9)), RATE, 3.9, (1.0, 20.0))
    omega = np.abs(found.modes[0])
    for wanted in np.abs(ROOTS):  # noise has stable poles, too, which a fit leaves out later
        nearest = int(np.argmin(np.abs(omega - wanted)))
        assert omega[nearest] == pytest.approx(wanted, rel=5e-3)
        assert np.sum(found.mode == nearest) > 20  # of some thirty orders
