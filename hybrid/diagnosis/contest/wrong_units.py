"""Sensors that show another unit than they say: gains far beyond those of a calibration, as the other sensors tell."""

from dataclasses import replace

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.sensor_effects import SensorGain
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.fitting.fitting import Fit
from hybrid.diagnosis.fitting.linearisation import orthonormal
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.loaded import given
from hybrid.diagnosis.response.system import drift, observability

FAR = 10.0  # prior standard deviations of a gain: no calibration is as far off


def with_other_units(candidates: tuple[Candidate, ...], short: Fit, gauge: Gauge) -> tuple[Candidate, ...]:
    """Return the candidates; a gain that the other sensors tell far off may be as far off as that.

    A channel in mm/s^2 shows a thousand times the truth, which a prior of calibrations would never believe. ``short``:
    the nominal fit of short segments.
    """
    factors = shown_factors(short, gauge)

    def wider(candidate: Candidate) -> Candidate:
        if candidate.kind != SensorGain.kind or candidate.sensor is None:
            return candidate
        off = float(abs(factors[candidate.sensor] - candidate.neutral[0]))
        return replace(candidate, width=(off,)) if off > FAR * candidate.width[0] else candidate

    return tuple(wider(candidate) for candidate in candidates)


def shown_factors(short: Fit, gauge: Gauge) -> FloatArray:
    """Return how many times what the others tell each sensor shows, (sensor,), of the linear structure as drawn.

    The initial states of each segment of a fit are those that the other sensors ask for.
    """
    drawn = Hypothesis(replace(short.hypothesis.plant, laws=()))
    system = drawn.system(drawn.centre[None], gauge.sensors, gauge.rate, gauge.positions)
    along, size = np.zeros((2, len(gauge.sensors)))
    for batch in short.batches:
        data = batch.data - given(system, batch)[0] - drift(system, batch.samples)[0]
        by_state = observability(system, batch.samples)[0]  # (time, sensor, state)
        for sensor in range(len(along)):
            others = np.arange(len(along)) != sensor
            rows = (by_state[:, others] / gauge.sigma[others, None]).reshape(-1, drawn.states)
            if not rows.any():  # they feel nothing, or there are none
                continue
            basis, upper = orthonormal(rows)
            taken = (data[..., others] / gauge.sigma[others]).reshape(len(data), -1) @ basis  # (recording, vector)
            told = np.linalg.solve(upper, taken.T).T @ by_state[:, sensor].T  # (recording, time)
            along[sensor] += np.vdot(told, data[..., sensor])
            size[sensor] += np.vdot(told, told)
    return np.where(size > 0, along / np.where(size > 0, size, 1.0), 1.0)
