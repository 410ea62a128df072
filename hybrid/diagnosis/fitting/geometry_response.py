"""What geometric forces add to the channels, to first order: they act along the motion as it would be without them."""

import numpy as np
from scipy.interpolate import make_interp_spline

from fe_models.dofs import FloatArray
from fe_models.recordings import QUANTITIES, Sensor
from hybrid.diagnosis.fitting.driven import History, driven, motion_of
from hybrid.diagnosis.fitting.fitting import Fit
from hybrid.diagnosis.nominal.geometry import Geometry
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.recorded.readout import Readout
from hybrid.diagnosis.recorded.records import Batch
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import System, free_form, passed

SMOOTH = 5  # degree of splines whose derivatives are taken: right to 0.1 % up to 0.3 of the sampling rate, ends apart
FELT = 0.01  # of noise's energy: where geometry adds less than that, or less more, it stays as it is


def added(hypothesis: Hypothesis, theta: FloatArray, states: FloatArray, batch: Batch, readout: Readout) -> FloatArray:
    """Return what geometry adds to the channels (recording, time, sensor) of motions.

    ``states`` (recording, state): where they begin; ``batch``: of which recordings. Zero where the plant has no
    geometry, and where the motion explodes.
    """
    sensors = readout.sensors
    found, geometry = np.zeros((len(states), batch.samples, len(sensors))), hypothesis.plant.geometry
    if geometry is None:
        return found
    system, n = system_of(hypothesis, theta[None], readout), hypothesis.size
    motion = motion_of(system, states, batch.samples, batch.loads)
    if motion is None:
        return found
    reduced, form = hypothesis.reduced(theta[None]), free_form(system, n)
    shapes = reduced.shapes[0]  # (dof, vector)
    picked = shapes.T @ geometry.weighted  # (vector, mode)
    coordinates = History(motion.now[..., :n] @ picked, motion.between[..., :n] @ picked)
    now, between = geometry.at(coordinates.now), geometry.at(coordinates.between)
    rows = hypothesis.plant.rows(sensors)
    moved = np.linalg.solve(reduced.mass[0], picked)
    accelerations = np.array([sensor.quantity == "acceleration" for sensor in sensors])
    direct = np.where(accelerations[:, None], rows @ shapes @ moved, 0.0)
    direct = direct * system.gain[0][:, None]
    for mode in range(picked.shape[1]):
        feed = np.zeros(system.A.shape[1])
        feed[n : 2 * n] = moved[:, mode]
        force = History(now[..., mode], between[..., mode])
        found += driven(form, 0, feed, direct[:, mode], force, system)
    return found + _given_way(geometry, coordinates, sensors, rows, system)


def _given_way(
    geometry: Geometry, coordinates: History, sensors: tuple[Sensor, ...], rows: FloatArray, system: System
) -> FloatArray:
    """Return what the channels (recording, time, sensor) show of modes that give way at once, as a column shortens.

    ``coordinates`` (time, recording, mode); ``rows`` (sensor, dof): what each sensor picks.
    """
    both = np.stack([coordinates.now, coordinates.between], axis=1)  # (time, half, recording, mode)
    bent = geometry.bent_at(both.reshape(-1, *both.shape[2:]), rows)
    halves = system.step / 2 * np.arange(len(bent))
    shown = []
    for position, (sensor, delay) in enumerate(zip(sensors, system.delay[0], strict=True)):
        curve = make_interp_spline(halves, bent[..., position], k=min(SMOOTH, len(bent) - 1), check_finite=False)
        shown.append(curve(halves[::2] - delay, nu=QUANTITIES.index(sensor.quantity)))
    return passed(np.stack(shown, axis=-1).swapaxes(0, 1) * system.gain[0], system)


def straightened(item: Fit, gauge: Gauge) -> tuple[Batch, ...] | None:
    """Return what was recorded less what geometry adds to the motion of a fit; None where that hardly changes."""
    batches, change = [], 0.0
    for batch, states in zip(item.batches, item.states, strict=True):
        y = added(item.hypothesis, item.theta, states, batch, gauge.readout)
        change += float(np.square((batch.recorded - batch.data - y) / batch.sigma(gauge)).sum())
        batches.append(batch.less(y))
    return tuple(batches) if change > FELT * item.values else None
