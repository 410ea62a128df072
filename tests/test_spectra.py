"""Spectra of channels against Parseval's theorem and a sine on a line."""

import numpy as np

from fe_models.spectra import line_frequencies, power_spectrum


def test_power_sums_to_the_energy_of_the_channels() -> None:
    """Parseval: the sum of x^2 is that of |X|^2 over N, where all lines but the first and the last stand for two."""
    x = np.random.default_rng(0).standard_normal((3, 64, 2))
    power = power_spectrum(x, np.ones(64))
    weight = np.full(33, 2.0)
    weight[[0, -1]] = 1.0
    energy = np.einsum("rls,l->rs", power, weight) / 64
    np.testing.assert_allclose(energy, np.sum(x**2, axis=1), rtol=1e-12)  # rounding


def test_a_sine_on_a_line_shows_there_and_beside_it_alone() -> None:
    rate, samples = 50.0, 200
    frequencies = line_frequencies(samples, rate)
    wave = np.sin(2 * np.pi * frequencies[20] * np.arange(samples) / rate)[:, None]
    power = power_spectrum(wave)[:, 0]
    assert frequencies[20] == 5.0
    assert power.argmax() == 20
    assert power[[*range(17), *range(24, 101)]].max() < 1e-4 * power[20]  # Hann's window leaks into two lines a side
