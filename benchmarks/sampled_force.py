"""What the samples of a force tell of a motion: one mass with a cubic spring, its force known by samples alone.

    x'' + 2 xi w x' + w^2 x (1 + c x^2) = f(t)

from rest, by the true equation throughout: all that is off is off by how the force goes between its samples. Forecasts
take it as the smooth curve through these. Frequencies are over the sampling rate, times in samples.
"""

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

from benchmarks.row import Row
from fe_models.arrays import FloatArray
from fe_models.interpolant import Course, interpolant

SAMPLES, QUICK_SAMPLES = 2000, 600
FREQUENCY, RATIO = 0.1, 0.05  # natural frequency and damping ratio: what begins falls by e in 32 samples
STEPS = 8  # of the integration a sample; truth and forecast take the same, so that their errors are the same
ORDER = 4  # of the Butterworth filter, which passes forwards and backwards: above the band forces fall as f^-8
SHARES = (0.0, 0.05, 0.3)  # by how much the spring stiffens on average: mean of 3 c x^2 over the linear motion


@dataclass(frozen=True)
class Case:
    """A random force up to a ``band``, and how it goes between its samples; None: as it went before it was sampled."""

    words: str
    band: float
    course: Course | None


CASES = (
    Case("finely simulated, then sampled, band 0.3 of the rate", 0.3, None),
    Case("the same, band 0.4", 0.4, None),
    Case("in straight lines between samples, band 0.3", 0.3, "straight"),
    Case("held from sample to sample, band 0.3", 0.3, "held"),
)


def rows(quick: bool = False) -> list[Row]:
    """Return the error of each forecast over the motion's root mean square, in the later half."""
    samples = QUICK_SAMPLES if quick else SAMPLES
    found = []
    for case in CASES:
        errors = forecast_errors(case, samples)
        for share, error in zip(SHARES, errors, strict=True):
            spring = f"stiffens by {share:.0%}" if share else "no cubic spring"
            found.append(Row("sampled force", f"{case.words}; {spring}", float(error)))
    return found


def forecast_errors(case: Case, samples: int) -> FloatArray:
    """Return the error (share,) of a forecast by the smooth curve through the samples of a case's force."""
    truth, taken = _forces(case, samples)
    (linear,) = _motions(truth[:, None], np.zeros(1)).T
    cubic = np.array(SHARES) / (3 * np.mean(linear[samples // 2 :] ** 2))
    count = len(cubic)
    forces = np.repeat(np.stack([truth, taken], axis=1), count, axis=1)  # (time, 2 share)
    motions = _motions(forces, np.tile(cubic, 2))[samples // 2 :]
    off = motions[:, count:] - motions[:, :count]
    return np.asarray(np.sqrt(np.mean(off**2, axis=0) / np.mean(motions[:, :count] ** 2, axis=0)))


def _forces(case: Case, samples: int) -> tuple[FloatArray, FloatArray]:
    """Return a force as it goes in truth and as forecasts take it, (time,) each, at every half step."""
    fine, rng = 2 * STEPS, np.random.default_rng(0)
    times = np.arange(fine * (samples - 1) + 1) / fine
    low = butter(ORDER, case.band, fs=fine, output="sos")
    force = sosfiltfilt(low, rng.standard_normal(len(times)))
    values = force[::fine] / force.std()
    truth = force / force.std() if case.course is None else interpolant(values, course=case.course)(times)
    return truth, interpolant(values)(times)


def _motions(forces: FloatArray, cubic: FloatArray) -> FloatArray:
    """Return displacements (sample, mass) from rest under ``forces`` (half step, mass), ``cubic`` (mass,): c.

    By the classical method of Runge and Kutta.
    """
    omega, step = 2 * np.pi * FREQUENCY, 1 / STEPS

    def rate(state: FloatArray, force: FloatArray) -> FloatArray:
        x, v = state
        return np.stack([v, force - 2 * RATIO * omega * v - omega**2 * x * (1 + cubic * x**2)])

    state, kept = np.zeros((2, len(cubic))), [np.zeros(len(cubic))]
    for number in range(0, len(forces) - 1, 2):
        begin, middle, end = forces[number : number + 3]
        a = rate(state, begin)
        b = rate(state + step / 2 * a, middle)
        c = rate(state + step / 2 * b, middle)
        d = rate(state + step * c, end)
        state = state + step / 6 * (a + 2 * b + 2 * c + d)
        if (number // 2 + 1) % STEPS == 0:
            kept.append(state[0])
    return np.array(kept)
