"""Sensors that show another unit than they say: gains far beyond those of a calibration, as the other sensors show."""

from dataclasses import replace

import numpy as np

from fe_models.causes.candidate import Candidate, SensorCandidate
from hybrid.diagnosis.contest.config import WRONG_UNIT
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.fitting.linearisation import orthonormal
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.loaded import given
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import drift, observability


def with_other_units(candidates: tuple[Candidate, ...], short: Fit, noise_model: NoiseModel) -> tuple[Candidate, ...]:
    """Return the candidates; the gain of a sensor that the others show far off may be as far off, and begins there.

    A channel in mm/s^2 shows a thousand times the truth, which a prior of calibrations would never believe. ``short``:
    the nominal fit of short segments.
    """
    sensor, factor = shown_otherwise(short, noise_model)
    if 1 / WRONG_UNIT.min_ratio < factor < WRONG_UNIT.min_ratio:
        return candidates

    def wider(candidate: Candidate) -> Candidate:
        if not (isinstance(candidate, SensorCandidate) and candidate.quantity == "gain" and candidate.sensor == sensor):
            return candidate
        width = max(candidate.width[0], abs(factor - candidate.neutral[0]))
        return replace(candidate, width=(width,), starts=((factor,),), scalable=False)

    return tuple(wider(candidate) for candidate in candidates)


def shown_otherwise(short: Fit, noise_model: NoiseModel) -> tuple[int, float]:
    """Return the sensor without which the others agree best, and how many times what they expect it shows; 1 where they
    do not agree far better without it.

    The initial states of each segment of a fit are those that the sensors ask for, of the linear structure as drawn.
    """
    drawn = Hypothesis(replace(short.hypothesis.nominal, laws=()))
    system = system_of(drawn, drawn.centre[None], noise_model.outputs)
    count = len(noise_model.sensors)
    along, size, left = np.zeros(count), np.zeros(count), np.zeros(count + 1)
    for batch in short.batches:
        data = batch.data - given(system, batch)[0] - drift(system, batch.samples)[0]
        by_state = observability(system, batch.samples)[0]  # (time, sensor, state)
        for sensor in range(count + 1):  # the last time with all of them
            others = np.arange(count) != sensor
            rows = (by_state[:, others] / noise_model.sigma[others, None]).reshape(-1, drawn.states)
            values = (data[..., others] / noise_model.sigma[others]).reshape(len(data), -1)
            if not rows.any():  # they feel nothing, or there are none
                left[sensor] += np.square(values).sum()
                continue
            basis, upper = orthonormal(rows)
            taken = values @ basis  # (recording, vector)
            left[sensor] += np.square(values).sum() - np.square(taken).sum()
            if sensor < count:
                told = np.linalg.solve(upper, taken.T).T @ by_state[:, sensor].T  # (recording, time)
                along[sensor] += np.vdot(told, data[..., sensor])
                size[sensor] += np.vdot(told, told)
    best = int(np.argmin(left[:count]))
    alone = size[best] <= 0 or left[best] > WRONG_UNIT.max_left_share * left[count]
    return best, 1.0 if alone else float(along[best] / size[best])
