"""The score test of harmonic forces: which frequency at which place explains most, by its steady state."""

import numpy as np

from fe_models.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from fe_models.causes.candidate import Candidate, HarmonicCandidate
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.fitting.linearisation import linearise_batch
from hybrid.diagnosis.recorded.config import SPECTRA
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.spectra import combination_lines, energy_near
from hybrid.diagnosis.response.load_input import feedthrough
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.screening.config import SCREENING
from hybrid.diagnosis.screening.screening import Screened


def screen_forces(fit: Fit, candidates: tuple[Candidate, ...], noise_model: NoiseModel) -> list[Screened]:
    """Return harmonic forces with their best frequencies, from the steady state that each frequency would bring.

    The transient is one of the initial states' motions, which are projected out. Amplitude and phase are each
    recording's own. The fit should be of whole recordings: segments do not determine frequencies well.
    """
    forces = [candidate for candidate in candidates if isinstance(candidate, HarmonicCandidate)]
    if not forces:
        return []
    hypothesis = fit.hypothesis
    system = system_of(hypothesis, fit.theta[None], noise_model.outputs)
    n = hypothesis.size
    reduced = hypothesis.reduced(fit.theta[None])
    inverse = np.linalg.inv(reduced.mass)
    longest = max(batch.samples for batch in fit.batches)
    count = longest * SCREENING.frequencies_per_line
    lines = np.arange(SCREENING.frequencies_per_line, count // 2)
    trials = lines * noise_model.rate / count
    feed = np.stack([reduced.fed(force.pull, inverse)[0] for force in forces], axis=1)  # (mode, place)
    B = np.zeros((2 * n, len(forces)))  # the structure's own states: at another force's frequency its own are singular
    B[n:] = feed
    D = feedthrough(hypothesis.nominal.rows(noise_model.sensors) @ reduced.shapes[0], feed, noise_model.sensors)
    omega = 2j * np.pi * trials[:, None, None]
    pushed = np.broadcast_to(B, (len(trials), *B.shape))
    A, C = system.A[0, : 2 * n, : 2 * n], system.C[0, :, : 2 * n]
    transfer = C @ np.linalg.solve(omega * np.eye(2 * n) - A, pushed) + D
    transfer = transfer * system.gain[0][:, None]  # (frequency, sensor, place)
    gains = np.zeros((len(trials), len(forces)))
    for batch, states_found in zip(fit.batches, fit.states, strict=True):
        part = linearise_batch(hypothesis, fit.theta, batch, noise_model, states_found)
        assert part is not None  # it was fitted
        sigma = batch.sigma(noise_model)[:, 0]  # (recording, sensor), or one row for all
        for number, residual in enumerate(np.array_split(part.residual, len(sigma))):
            basis = part.basis[number] if part.basis.ndim == 3 else part.basis  # of laws: the first one's
            gains += _harmonic_gains(residual, basis, transfer / sigma[number][:, None], lines, count)
    if hypothesis.nominal.kept is not None:
        least = min(
            SCREENING.min_combination_share * _energy(fit, noise_model),
            max(SCREENING.min_residual_share * fit.misfit, fit.values),
        )
        gains[_is_of_structure(trials, A, fit, noise_model)[:, None] & (gains < least)] = 0.0
    found = []
    for place, candidate in enumerate(forces):
        curve = gains[:, place].copy()
        for _ in range(SCREENING.peaks_per_place):
            peak = int(np.argmax(curve))
            still = np.zeros(len(fit.theta))
            found.append(Screened(candidate, (float(trials[peak]),), float(curve[peak]), still))
            curve[max(0, peak - 2 * SCREENING.frequencies_per_line) : peak + 2 * SCREENING.frequencies_per_line + 1] = (
                0.0
            )
    return sorted(found, key=lambda trial: -trial.gain)


def _is_of_structure(trials: FloatArray, A: FloatArray, fit: Fit, noise_model: NoiseModel) -> BoolArray:
    """Return whether each frequency (Hz) is a multiple, sum or difference of the strongest modes' frequencies.

    ``A`` (state, state) of the structure alone: a machine that was found is none of its modes.
    """
    roots = np.linalg.eigvals(A)
    frequencies = np.sort(np.abs(roots[roots.imag > 0])) / (2 * np.pi)
    motion = tuple(batch.data / batch.sigma(noise_model) for batch in fit.batches)
    lines = combination_lines(frequencies, energy_near(frequencies, motion, noise_model.rate))
    resolution = noise_model.rate / max(batch.samples for batch in fit.batches)
    return np.asarray(np.abs(trials[:, None] - lines).min(axis=1) <= SPECTRA.line_width * resolution)


def _energy(fit: Fit, noise_model: NoiseModel) -> float:
    return sum(float(np.square(batch.data / batch.sigma(noise_model)).sum()) for batch in fit.batches)


def _harmonic_gains(
    residual: FloatArray, basis: FloatArray, transfer: ComplexArray, lines: IntArray, count: int
) -> FloatArray:
    """Return the fall in the sum of squares (frequency, place) by a harmonic force, free in each recording.

    ``residual`` (recording, value), of which the ``basis`` (value, vector) was projected out; ``transfer`` (frequency,
    sensor, place) is what the sensors show of a unit force, in units of the noise; ``lines`` (frequency,): the number
    of each frequency among those of ``count`` samples. All products with these are Fourier transforms, of the residual
    and of the basis.
    """
    sensors = transfer.shape[1]
    samples = len(basis) // sensors

    def turned(courses: FloatArray, at: IntArray) -> ComplexArray:
        """Return the sum of courses (time, ...) times exp(2 pi i at time / count), (frequency, ...)."""
        return np.asarray(np.fft.fft(courses, count, axis=0)[at % count].conj())

    along = turned(residual.reshape(-1, samples, sensors).transpose(1, 0, 2).reshape(samples, -1), lines)
    inside = turned(basis.reshape(samples, -1), lines)
    along = along.reshape(len(lines), -1, sensors) @ transfer  # (frequency, recording, place)
    inside = inside.reshape(len(lines), sensors, -1).transpose(0, 2, 1) @ transfer  # (frequency, state, place)
    size = samples * np.sum(np.abs(transfer) ** 2, axis=1) - np.sum(np.abs(inside) ** 2, axis=1)
    double = turned(np.ones((samples, 1)), 2 * lines) * np.sum(transfer**2, axis=1) - np.sum(inside**2, axis=1)
    a, b, c = (size + double.real) / 2, (size - double.real) / 2, double.imag / 2  # of cosines and sines
    ridge = 1e-9 * (a + b)
    a, b = a + ridge, b + ridge
    u, v = along.real, along.imag
    fall = u**2 * b[:, None] - 2 * u * v * c[:, None] + v**2 * a[:, None]
    return np.asarray(np.sum(fall, axis=1) / (a * b - c**2))
