"""What channels show beside a structure's motion: offsets and drifts of sensors, identified beside free decays."""

from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy import stats
from scipy.linalg import block_diag, eigh, orth

from fe_models.arrays import TINY, ComplexArray, FloatArray
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.recorded.config import MOTION_FREE


@dataclass(frozen=True)
class MotionFreeChannel:
    """What is slow in one channel of all training recordings, one behind the other, less what may be motion.

    ``values`` (value,), independent of one another; what becomes in the same way of an offset of one in each recording,
    ``own`` (recording, value), and of a drift of one a second, ``drift`` (value,). An offset is judged by them: what
    fitted motion leaves, of a structure that is not linear for one, is mostly slow, and no white noise.
    """

    values: FloatArray
    own: FloatArray
    drift: FloatArray

    def offset(self) -> float | None:
        """Return the offset that all recordings share; None where there is none, or a drift explains it as well."""
        none, alike, drift = self.own[:0], self.own.sum(axis=0)[None], self.drift[None]
        both = np.vstack([alike, drift])
        if (
            self._chance(none, alike) > MOTION_FREE.max_chance_of_offset
            or self._chance(drift, both) > MOTION_FREE.max_chance_of_drift
        ):
            return None
        return float(self._fit(both if self._chance(alike, both) < MOTION_FREE.max_chance_of_drift else alike)[0])

    def differing(self) -> FloatArray | None:
        """Return the offset of each recording (recording,) where these differ, whether or not there is a drift."""
        alike, all_courses = np.vstack([self.own.sum(axis=0), self.drift]), np.vstack([self.own, self.drift])
        if len(self.own) < 2 or self._chance(alike, all_courses) > MOTION_FREE.max_chance_of_offset:
            return None
        return self._fit(all_courses)[:-1]

    def _chance(self, fewer: FloatArray, more: FloatArray) -> float:
        """Return how often noise alone makes as much of what only ``more`` courses (course, value) explain.

        Of noise that is as strong in all values: an F test.
        """
        all_courses = np.vstack([self.own, self.drift])
        free, further = len(self.values) - len(all_courses), len(more) - len(fewer)
        if free < 1:
            return 1.0
        explained = (self._left(fewer) - self._left(more)) / further
        noise = max(self._left(all_courses) / free, (MOTION_FREE.rounding * np.abs(self.values).max()) ** 2, TINY)
        return float(stats.f.sf(explained / noise, further, free))

    def _left(self, courses: FloatArray) -> float:
        """Return the sum of squares that ``courses`` leave."""
        left = self.values - self._fit(courses) @ courses
        return float(left @ left)

    def _fit(self, courses: FloatArray) -> FloatArray:
        """Return the factor of each course."""
        return np.asarray(np.linalg.lstsq(courses.T, self.values, rcond=None)[0])


def motion_free_channels(dataset: Dataset, nominal: ComplexArray) -> tuple[MotionFreeChannel, ...]:
    """Return each channel (sensor,) beside motion; none where all recordings are too short to identify it.

    ``nominal`` (mode,): poles of the nominal structure (rad/s, one of each pair), as many as the recordings may show.
    """
    rate = dataset.sampling_rate
    period = 2 * np.pi / float(np.abs(nominal).min()) * rate  # of the slowest mode, in samples
    least = max(MOTION_FREE.min_periods * period, MOTION_FREE.min_samples_per_mode * len(nominal))
    courses = [_courses(r, part, rate) for r in dataset.select("train") for part in r.data if len(part) >= least]
    if not courses:
        return ()
    together = ceil(
        min(
            MOTION_FREE.max_stretch_share * min(map(len, courses)),
            MOTION_FREE.stretch_periods * period,
            MOTION_FREE.max_stretch_values / len(dataset.sensors),
        )
    )
    poles = _poles([each[:, :-2] for each in courses], together, 2 * (len(nominal) + MOTION_FREE.spare_modes))
    poles = poles[poles.imag > MOTION_FREE.min_frequency_share * 2 * np.pi / period]
    parts = [_slow_beside_motion(each, poles, len(each) / period) for each in courses]
    own = block_diag(*[part[:, -2] for part in parts])
    whole = np.concatenate(parts)
    return tuple(MotionFreeChannel(channel, own, whole[:, -1]) for channel in whole[:, :-2].T)


def _courses(recording: Recording, data: FloatArray, rate: float) -> FloatArray:
    """Return the channels of a motion (time, sensor), an offset of one and a drift of one a second, (time, course)."""
    time = (recording.skipped + np.arange(len(data))) / rate
    return np.column_stack([data, np.ones_like(time), time])


def _poles(motions: list[FloatArray], together: int, count: int) -> ComplexArray:
    """Return ``count`` poles, a sample, of ``motions`` (time, sensor) in all, identified from samples that come
    ``together``.

    What spans all such stretches turns by the poles from one sample to the next (ESPRIT; Roy & Kailath, 1989). An
    offset is a pole at zero.
    """
    size = np.maximum(np.sqrt(np.mean([motion.var(axis=0) for motion in motions], axis=0)), TINY)
    sensors = len(size)
    products = np.zeros((together * sensors, together * sensors))
    for motion in motions:
        stretches = sliding_window_view(motion / size, together, axis=0)  # (start, sensor, sample)
        flat = stretches.transpose(0, 2, 1).reshape(len(stretches), -1)
        products += flat.T @ flat
    count = min(count, (together - 1) * sensors)
    _, space = eigh(products, subset_by_index=(len(products) - count, len(products) - 1))
    turned = np.linalg.lstsq(space[:-sensors], space[sensors:], rcond=None)[0]
    return np.log(np.linalg.eigvals(turned).astype(complex))


def _slow_beside_motion(courses: FloatArray, poles: ComplexArray, periods: float) -> FloatArray:
    """Return the slow components (component, course) of ``courses`` (time, course) less free decays with ``poles``.

    Those are any course exp(s t) with a pole s (a sample), and t exp(s t): to first order, one with another frequency
    or damping. ``periods``: of the slowest mode in the recording. White noise has the same variance in all components.
    """
    time = np.arange(len(courses)) / len(courses)
    decays = np.exp(np.outer(time, np.minimum(poles.real, 0.0) * len(courses) + 1j * poles.imag * len(courses)))
    decays = np.hstack([decays, time[:, None] * decays])
    motion = orth(np.hstack([decays.real, decays.imag]))
    half_waves = max(ceil(2 * MOTION_FREE.min_frequency_share * periods), MOTION_FREE.min_half_waves)
    half_waves = min(half_waves, MOTION_FREE.max_half_waves)
    slow = np.column_stack([np.cos(np.pi * np.outer(time + 0.5 / len(time), np.arange(half_waves))), courses[:, -1]])
    slow /= np.linalg.norm(slow, axis=0)
    beside = orth(slow - motion @ (motion.T @ slow), rcond=MOTION_FREE.min_share_beside_motion)
    return np.asarray(beside.T @ courses)
