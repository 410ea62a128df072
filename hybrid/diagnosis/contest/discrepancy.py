"""Recordings far cleaner than the model is right: what the model lacks then counts as noise while causes are sought.

Where the nominal model leaves fifty times the noise, noise alone would let every nominal value run away from what
its owner knows, for gains that mean nothing. The noise is then taken as large as what is left, and its energy larger by
the number of values that are worth one independent value: errors of a model are slow, and repeat themselves (Bartlett).
"""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.contest.config import NOISE_LEVEL
from hybrid.diagnosis.contest.growing import Lengths, short_fit
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.recorded.noise_model import NoiseModel


def search_noise_model(
    nominal: NominalModel, lengths: Lengths, noise_model: NoiseModel, short: Fit
) -> tuple[NoiseModel, Lengths, Fit]:
    """Return the noise model to search with, the segments, and the nominal fit of the shortest; mostly as they are.

    What the model lacks is no less in recordings that have less noise.
    """
    if short.chi2 < NOISE_LEVEL.astray_ratio * short.values:
        return noise_model, lengths, short
    lengths = lengths.alike
    factor, found = 1.0, noise_model
    for _ in range(NOISE_LEVEL.rounds):
        left = factor * short.chi2 / short.values  # over the energy of noise as the recordings tell it
        factor = left * repeated(short.residuals)
        found = replace(noise_model, sigma=noise_model.sigma * np.sqrt(factor))
        short = short_fit(nominal, lengths, found)
    return found, lengths, short


def in_units_of(noise_model: NoiseModel, item: Fit, searched: NoiseModel) -> Fit:
    """Return a fit that was ``searched`` with some noise in units of the noise of ``noise_model``.

    Theta stays as it is, and so do the standard deviations of theta and of initial states.
    """
    scale = searched.sigma / noise_model.sigma
    residuals = tuple(part * scale for part in item.residuals)
    chi2 = sum(float(np.square(part).sum()) for part in residuals)
    return replace(item, residuals=residuals, chi2=chi2, cost=item.cost - item.chi2 + chi2)


def energy_over(noise_model: NoiseModel, searched: NoiseModel) -> float:
    """Return the energy of what counted as noise in the search over that of the noise of ``noise_model``."""
    return float(np.mean((searched.sigma / noise_model.sigma) ** 2))


def repeated(residuals: tuple[FloatArray, ...]) -> float:
    """Return 1 + 2 sum rho_k^2 over all lags k up to a third of a recording: the values that are worth one independent
    value.
    """
    most = min(part.shape[1] for part in residuals) // 3
    covariance = np.zeros(most)
    for part in residuals:
        power = np.sum(np.abs(np.fft.rfft(part, 2 * part.shape[1], axis=1)) ** 2, axis=(0, 2))
        covariance += np.fft.irfft(power)[:most]
    rho = covariance / covariance[0]
    return float(1 + 2 * np.sum(rho[1:] ** 2))
