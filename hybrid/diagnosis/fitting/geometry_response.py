"""What geometric forces add to the channels: as known loads on modes they act along the motion, and change it.

The motion is taken without them at first, then with those along it, and so on: each time the rest is some hundred times
smaller. Force laws answer as well: under a soft spring what geometry adds may be twice as much.
"""

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline

from fe_models.dofs import FloatArray
from fe_models.recordings import QUANTITIES, Sensor
from hybrid.diagnosis.fitting.driven import sampled_motion
from hybrid.diagnosis.fitting.fitting import Fit
from hybrid.diagnosis.nominal.geometry import Geometry
from hybrid.diagnosis.nominal.loads import ORDERS, Loads
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.recorded.readout import Readout
from hybrid.diagnosis.recorded.records import Batch
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import Entry, System, passed

ROUNDS = 3  # of taking forces along a motion
OFTEN = 2  # times the sampling rate: how often forces are told, which go with three times the highest frequency
SMOOTH = 5  # degree of splines whose derivatives are taken: right to 0.1 % up to 0.3 of the sampling rate, ends apart
FELT = 0.01  # of noise's energy: where geometry adds less than that, or less more, it stays as it is


def added(hypothesis: Hypothesis, theta: FloatArray, states: FloatArray, batch: Batch, readout: Readout) -> FloatArray:
    """Return what geometry adds to the channels (recording, time, sensor) of motions.

    ``states`` (recording, state): where they begin; ``batch``: of which recordings. Zero where the plant has no
    geometry, and where the motion explodes.
    """
    nothing, geometry = np.zeros((len(states), batch.samples, len(readout.sensors))), hypothesis.plant.geometry
    if geometry is None:
        return nothing
    often = OFTEN if batch.loads is None else 1  # known loads are told once a sample
    system = system_of(hypothesis, theta[None], readout)
    fine = replace(system, step=system.step / often)
    straight = replace(fine, lowpass=None)  # the difference passes it
    bent = replace(straight, loads=_entry(hypothesis, theta, readout.sensors, straight))
    picked, samples = _picked(hypothesis, theta), often * batch.samples
    moving, loads = straight, batch.loads
    for _ in range(ROUNDS):
        motion = sampled_motion(moving, states, samples, loads)
        if motion is None:
            return nothing
        coordinates = motion[..., : hypothesis.size] @ picked  # (time, recording, mode)
        moving, loads = bent, _loads(geometry.at(coordinates), bent, batch.loads)
    without, with_it = (
        respond(moved, states[None], samples, given)[0] for moved, given in ((straight, batch.loads), (bent, loads))
    )
    if not np.isfinite(with_it).all():
        return nothing
    shown = passed(with_it - without, fine) + _given_way(geometry, coordinates, hypothesis, readout.sensors, fine)
    return np.asarray(shown[:, ::often])


def _picked(hypothesis: Hypothesis, theta: FloatArray) -> FloatArray:
    """Return what modal coordinates of the nominal structure are of the hypothesis' own (vector, mode)."""
    geometry = hypothesis.plant.geometry
    assert geometry is not None  # its caller has seen to that
    return np.asarray(hypothesis.reduced(theta[None]).shapes[0].T @ geometry.weighted)


def _entry(hypothesis: Hypothesis, theta: FloatArray, sensors: tuple[Sensor, ...], system: System) -> Entry:
    """Return how known loads enter a system, and behind them forces on the modes of which geometry tells."""
    reduced, picked, n = hypothesis.reduced(theta[None]), _picked(hypothesis, theta), hypothesis.size
    modes = picked.shape[1]
    feed = np.zeros((1, 2 * n, modes))
    feed[0, n:] = np.linalg.solve(reduced.mass[0], picked)
    accelerations = np.array([sensor.quantity == "acceleration" for sensor in sensors])
    rows = hypothesis.plant.rows(sensors)
    own = Entry(
        places=tuple((mode + 1, "mode") for mode in range(modes)),
        feed=feed,
        direct=np.where(accelerations[:, None], rows @ reduced.shapes[0] @ feed[0, n:], 0.0)[None],
        bent=np.zeros((3, len(sensors), modes)),  # what gives way at once is told apart
        stretch=np.zeros((len(system.forces), modes)),
    )
    return own if system.loads is None else system.loads.and_at(own)


def _loads(forces: FloatArray, system: System, known: Loads | None) -> Loads:
    """Return modal ``forces`` (time, recording, mode) as loads of a system, and those ``known`` beside them."""
    entry = system.loads
    assert entry is not None  # forces on modes are in it
    times = system.step * np.arange(len(forces))
    curve = CubicSpline(times, forces.swapaxes(0, 1), axis=1)
    own = Loads(entry.places[-forces.shape[2] :], np.stack([curve(times, order) for order in range(ORDERS)]))
    return own if known is None else Loads(entry.places, own.at(entry.places) + known.at(entry.places))


def _given_way(
    geometry: Geometry, coordinates: FloatArray, hypothesis: Hypothesis, sensors: tuple[Sensor, ...], system: System
) -> FloatArray:
    """Return what the channels (recording, time, sensor) show of modes that give way at once, as a column shortens, at
    modal ``coordinates`` (time, recording, mode).
    """
    bent = geometry.bent_at(coordinates, hypothesis.plant.rows(sensors))
    times, shown = system.step * np.arange(len(bent)), []
    for position, (sensor, delay) in enumerate(zip(sensors, system.delay[0], strict=True)):
        curve = make_interp_spline(times, bent[..., position], k=min(SMOOTH, len(bent) - 1), check_finite=False)
        shown.append(curve(times - delay, nu=QUANTITIES.index(sensor.quantity)))
    return passed(np.stack(shown, axis=-1).swapaxes(0, 1) * system.gain[0], system)


def straightened(item: Fit, gauge: Gauge) -> tuple[Batch, ...] | None:
    """Return what was recorded less what geometry adds to the motion of a fit; None where that hardly changes."""
    batches, change = [], 0.0
    for batch, states in zip(item.batches, item.states, strict=True):
        y = added(item.hypothesis, item.theta, states, batch, gauge.readout)
        change += float(np.square((batch.recorded - batch.data - y) / batch.sigma(gauge)).sum())
        batches.append(batch.less(y))
    return tuple(batches) if change > FELT * item.values else None
