"""How much of a residual is noise: white at all frequencies, what a model lacks is at the structure's."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import BoolArray, ComplexArray, FloatArray
from fe_models.spectra import line_frequencies, power_spectrum, windowed_spectrum
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.config import NOISE

WHITE_QUANTILE = -np.log(1 - NOISE.quantile)  # that of white noise's power over its mean
# variance of the density estimated so over that by the mean
QUARTILE_LOSS = NOISE.quantile / (1 - NOISE.quantile) / WHITE_QUANTILE**2


@dataclass(frozen=True)
class Band:
    """Where a structure's motion shows in the spectra of its recordings, up to ``upper`` (Hz), and where noise does.

    With ``room`` noise alone is above, up to half the sampling rate. Without, be it that a low-pass has taken it away
    or that the structure has modes there, too, noise is what lies between the lines once most modes have died away.
    """

    upper: float
    room: bool


def structure_band(nominal: NominalModel, rate: float, lowpass: float | None = None, white: bool = False) -> Band:
    """Return the band of a structure in recordings with a sampling ``rate`` and a ``lowpass`` (Hz).

    ``white``: whether noise came after the low-pass, beyond which it is alone then, or there is no low-pass.
    """
    half, highest = rate / 2, float(nominal.modes[0][-1]) / (2 * np.pi)
    passed = half if lowpass is None else min(lowpass, half)
    if (
        nominal.kept is None
        and (white or passed == half)
        and NOISE.close_over_highest * highest < NOISE.max_band_share * half
    ):
        return Band(min(NOISE.band_over_highest * highest, NOISE.max_band_share * half), room=True)
    if white and NOISE.clear_of_lowpass * passed < NOISE.passed_by_lowpass * half:
        return Band(NOISE.clear_of_lowpass * passed, room=True)
    return Band(NOISE.passed_by_lowpass * (half if white else passed), room=False)


def noise_of_recordings(batches: tuple[Batch, ...], rate: float, band: Band) -> FloatArray:
    """Return the standard deviation of the noise (sensor,) as white noise of the same density would have it.

    With a Hann window, so that a decay which the recording cuts off does not leak into all frequencies.
    """
    if not band.room:
        return np.sqrt(_quiet_density(tuple(batch.data for batch in batches), rate, band))
    lower = _lower(rate, band)
    power, count = 0.0, 0
    for batch in batches:
        window = np.hanning(batch.samples)
        above = line_frequencies(batch.samples, rate) > lower
        spectra = windowed_spectrum(batch.data, window)[:, above]
        density = np.abs(spectra) ** 2 / np.sum(window**2)
        share = 1.0
        if batch.loads is not None:
            pushes = windowed_spectrum(batch.loads.courses[0], window)[:, above]
            left, share = _unexplained(spectra, pushes, line_frequencies(batch.samples, 1.0)[above])
            density = np.abs(left) ** 2 / np.sum(window**2)
        power = power + density.sum(axis=(0, 1))
        count += density.shape[0] * density.shape[1] * share
    return np.asarray(np.sqrt(power / count))


def variance_of_log_noise(samples: int, rate: float, band: Band) -> float:
    """Return the variance of the logarithm of the noise's standard deviation, as estimated from one recording."""
    if band.room:
        return NOISE.lines_per_independent / 4 / float(np.sum(line_frequencies(samples, rate) > _lower(rate, band)))
    return NOISE.lines_per_independent * QUARTILE_LOSS / 4 / float(np.sum(_lines(_end(samples), rate, band)))


def _lower(rate: float, band: Band) -> float:
    """Return the frequency (Hz) beyond which recordings show their noise themselves, where there is room."""
    return max(
        band.upper,
        NOISE.min_noise_frequency_share * rate / 2,
        min(NOISE.harmonics_ratio * band.upper, NOISE.max_noise_frequency_share * rate / 2),
    )


def _end(samples: int) -> int:
    """Return how many of a recording's last samples are quiet."""
    return max(int(NOISE.quiet_share * samples), 2)


def _lines(samples: int, rate: float, band: Band) -> BoolArray:
    """Return which lines (frequency,) of a spectrum lie in the band; of a short recording the first in any case."""
    frequencies = line_frequencies(samples, rate)
    return np.asarray((frequencies > 0) & (frequencies <= max(band.upper, frequencies[1])))


def _unexplained(spectra: ComplexArray, pushes: ComplexArray, frequencies: FloatArray) -> tuple[ComplexArray, float]:
    """Return spectra (recording, frequency, sensor) less what loads explain, and the share of values that are left.

    ``pushes`` (recording, frequency, load). Far above all natural frequencies omega a structure answers to a load as a
    series in 1 / (i omega) with real coefficients, whatever its masses are; they are found by least squares.
    """
    turns = (0.5 / (1j * frequencies[:, None])) ** np.arange(NOISE.load_series_terms)  # (frequency, power)
    columns = (pushes[..., None] * turns[:, None]).reshape(-1, pushes.shape[2] * NOISE.load_series_terms)
    rows = spectra.reshape(-1, spectra.shape[2])
    X, y = (np.concatenate([part.real, part.imag]) for part in (columns, rows))
    size = np.linalg.norm(X, axis=0)
    X = X[:, size > 0] / size[size > 0]
    left = y - X @ np.linalg.lstsq(X, y, rcond=None)[0]
    rest = (left[: len(rows)] + 1j * left[len(rows) :]).reshape(spectra.shape)
    return rest, max(1 - X.shape[1] / len(y), NOISE.min_unexplained_share)


def _quiet_density(parts: tuple[FloatArray, ...], rate: float, band: Band) -> FloatArray:
    """Return the variance (sensor,) of white noise as dense as what lies between the lines, at recordings' ends."""
    powers = []
    for part in parts:
        end = part[:, -_end(part.shape[1]) :]
        window = np.hanning(end.shape[1])
        density = power_spectrum(end, window) / np.sum(window**2)
        powers.append(density[:, _lines(end.shape[1], rate, band)].reshape(-1, part.shape[2]))
    return np.asarray(np.quantile(np.concatenate(powers), NOISE.quantile, axis=0) / WHITE_QUANTILE)


@dataclass(frozen=True)
class Excess:
    """The energy of residuals in the structure's band beyond white noise, in units of the noise's variance.

    ``total`` and its standard deviation ``std`` if there were none; ``sigma`` (sensor,) the noise, in units of the
    residuals.
    """

    total: float
    std: float
    sigma: FloatArray

    @property
    def significant(self) -> bool:
        """Whether chance alone hardly makes as much."""
        return self.total > NOISE.max_excess_sigma * self.std


def excess(residuals: tuple[FloatArray, ...], rate: float, band: Band) -> Excess:
    """Return the structured part of residuals, one array (recording, time, sensor) for each batch."""
    low, high, counts = [], 0.0, np.zeros(2)
    for part in residuals:
        samples = part.shape[1]
        density = power_spectrum(part, np.ones(samples)) / samples  # of white noise: its variance
        weight = np.full(density.shape[1], 2.0)  # each frequency but the first stands for two
        weight[0] = 1.0
        within = line_frequencies(samples, rate) <= band.upper
        low.append((np.einsum("rfs,f->rs", density[:, within], weight[within]), float(weight[within].sum())))
        high = high + density[:, ~within].sum(axis=(0, 1))
        counts += len(part) * np.array([weight[within].sum(), (~within).sum()])
    if not band.room:
        counts[1] = NOISE.quiet_share * counts[0] / 2 / QUARTILE_LOSS
    variance = high / counts[1] if band.room else _quiet_density(residuals, rate, band)  # (sensor,)
    total = sum(float(np.sum(energy / variance - bins)) for energy, bins in low)
    sensors = len(variance)
    std = float(np.sqrt(2 * counts[0] * sensors + (counts[0] ** 2) * sensors / counts[1]))
    return Excess(total, std, np.sqrt(variance))


def correlation_factor(residuals: tuple[FloatArray, ...]) -> float:
    """Return 1 + 2 sum rho_k over the significant autocorrelations: how many values are worth one independent value."""
    most = min(NOISE.max_lags, int(NOISE.max_lag_share * min(part.shape[1] for part in residuals)))
    covariance, values = np.zeros(most), 0
    for part in residuals:
        scaled = part / np.sqrt(np.mean(part**2, axis=(0, 1)))
        values += scaled.size
        covariance += [float(np.sum(scaled[:, : scaled.shape[1] - k] * scaled[:, k:])) for k in range(most)]
    rho = covariance / covariance[0]
    small = np.flatnonzero(rho < NOISE.min_correlation_sigma / np.sqrt(values))
    first = int(small[0]) if len(small) else most
    return float(1 + 2 * rho[1:first].sum())
