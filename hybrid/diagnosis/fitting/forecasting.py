"""Forecasts of recordings from their first fifth, for every model alike, and what a perfect model would score."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.recordings import Sensor
from hybrid.diagnosis.fitting.fitting import Fit
from hybrid.diagnosis.fitting.geometry_response import added
from hybrid.diagnosis.nominal.scatter import OWN
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.recorded.records import Batch, columns_of, count_of
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.loaded import given, loaded_size
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import System, drift, drifted, observability

SHOWN = 0.2  # of each recording: what its initial state is estimated from
GROWTH = (0.15, 0.25, 0.35, 0.5, 0.7, 1.0)  # of that, where force laws act: so that the search begins near
ITERATIONS = 20  # at most, of each
DAMPING = (1e-3, 10.0)  # of Levenberg and Marquardt: at first, and how much less or more after a step
ENOUGH = 0.01  # of a sum of squares in units of the noise: a step that promises less is not taken
EXPLODED = 1e6  # of a channel: what stands for a motion beyond all bounds
STEP = 1e-4  # of a state's prior size
ORDERLY = 6.0  # in a cost: 2 log 20, as one of twenty recordings is not as those before and after it are
ROUNDS = 3  # of taking away what geometry adds to a motion, which tells what it adds
TINY = 1e-300  # instead of nothing
DEVIATION = 2.5  # of its stated standard deviations: how far a nominal value may be calibrated


@dataclass(frozen=True)
class Model:
    """A hypothesis at one ``theta`` (parameter,), and the ``size`` (state,) that initial states had in training.

    ``switched``: numbers of candidates that act in some recordings only; in each the better choice is taken, where
    ``idle`` (by name) tells how much cost it adds that they do not act: see `idle_by_order`.
    """

    hypothesis: Hypothesis
    theta: FloatArray
    size: FloatArray
    switched: tuple[int, ...] = ()
    idle: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Forecast:
    """``nrmse`` and ``floor`` (recording, sensor); ``energy`` and ``floor_energy``: of the measured channels' errors,
    in units of the noise's variance, of the model and of a perfect one.
    """

    nrmse: FloatArray
    floor: FloatArray
    energy: float
    floor_energy: float

    @property
    def excess(self) -> float:
        """The energy of errors beyond that of a perfect model; more than nothing, as shares of it are told."""
        return max(self.energy - self.floor_energy, TINY)


@dataclass(frozen=True)
class Begun:
    """Initial ``states`` (recording, state), their ``cost`` (recording,), and what geometry adds to the motion from
    there, ``geometric`` (recording, time, sensor); none of a linear model.
    """

    states: FloatArray
    cost: FloatArray
    geometric: FloatArray


def shown_of(samples: int) -> int:
    """Return how many of a recording's ``samples`` its initial state is estimated from; the others are forecast."""
    return max(int(np.ceil(SHOWN * samples)), 2)


def within(item: Fit, most: float) -> FloatArray:
    """Return the theta (parameter,) of a fit, nominal values no further off than ``most`` standard deviations.

    As far as its ``deviations`` tell them.
    """
    count, factors = item.hypothesis.nuisances, item.hypothesis.plant.factors
    farthest = most * item.hypothesis.width[:count]
    least, whole = -farthest, farthest[:factors] >= 1  # which no factor can be below nominal
    least[:factors] = np.where(whole, -np.inf, np.log1p(-np.where(whole, 0.0, farthest[:factors])))
    return np.append(np.clip(item.theta[:count], least, farthest), item.theta[count:])


def deviation_of(item: Fit) -> float:
    """Return how far the calibration of a fit goes, at most, in stated standard deviations."""
    return float(np.abs(item.deviations).max())


def deviation_of_groups(item: Fit) -> float:
    """Return how far it goes where an element by itself may be as far off as its group: nobody stated how far one
    differs from it, and the quarter of the group's uncertainty that a search takes is a guess.
    """
    plant, off = item.hypothesis.plant, np.abs(item.deviations)
    return float(np.append(off[: plant.factors], OWN * off[plant.factors :]).max())


def goes_far(item: Fit) -> bool:
    """Return whether the calibration of a fit goes further than is normal, so that it may hide what led it there."""
    return deviation_of(item) > DEVIATION


def model_of(item: Fit, gauge: Gauge, theta: FloatArray | None = None) -> Model:
    """Return a fit's model for forecasts; the size of initial states is that of the training recordings.

    Under known loads it is that of the motion: others may begin within it, though these began at rest.
    """
    most = max(range(len(item.states)), key=lambda i: item.states[i].shape[1])
    full = [states for states in item.states if states.shape[1] == item.states[most].shape[1]]
    size = np.sqrt(np.mean(np.concatenate(full) ** 2, axis=0) + _pushed(item, gauge))
    theta = item.theta if theta is None else theta
    return Model(item.hypothesis, theta, np.maximum(size, 1e-6 * size.max()), switched_in(item))


def switched_in(item: Fit) -> tuple[int, ...]:
    """Return the numbers of a fit's candidates that act in some recordings only."""
    return tuple(sorted({number for batch in item.batches for number in batch.off}))


def idle_by_order(item: Fit, order: Sequence[str]) -> dict[str, float]:
    """Return what it adds to a recording's cost that what acts in some recordings only is idle there.

    By those fitted before and after it in the ``order`` in which they were made, where these agree: its first fifth may
    not tell (a stop that is not hit so early). Nothing where several motions share a name.
    """
    idle = {name: bool(batch.off) for batch in item.batches for name in batch.names}
    if len(idle) < count_of(item.batches) or len(set(order)) < len(order):
        return {}
    found = {}
    for number, name in enumerate(order):
        sides = {
            idle[side[0]]
            for side in ([n for n in part if n in idle] for part in (order[number::-1], order[number:]))
            if side
        }
        if len(sides) == 1:
            found[name] = -ORDERLY if sides.pop() else ORDERLY
    return found


def _pushed(item: Fit, gauge: Gauge) -> FloatArray:
    """Return the mean squares (state,) of the motion that known loads make of rest in a fit's recordings."""
    loaded = [batch for batch in item.batches if batch.loads is not None]
    system = system_of(item.hypothesis, item.theta[None], gauge.sensors, gauge.rate, gauge.positions)
    sizes = [len(batch.names) * loaded_size(system, batch.loads) for batch in loaded if batch.loads is not None]
    return np.sum(sizes, axis=0) / count_of(item.batches) if sizes else np.zeros(1)


def forecast(
    model: Model, batches: tuple[Batch, ...], sensors: tuple[Sensor, ...], measured: tuple[int, ...], gauge: Gauge
) -> Forecast:
    """Return the scores over the last 80 % of the recordings, of all ``sensors``; ``measured``: those fitted."""
    parts = [_one(model, batch, sensors, measured, gauge) for batch in batches]
    nrmse, floor = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    return Forecast(nrmse, floor, float(sum(part[2] for part in parts)), float(sum(part[3] for part in parts)))


def predicted(
    model: Model, batch: Batch, sensors: tuple[Sensor, ...], measured: tuple[int, ...], gauge: Gauge
) -> FloatArray:
    """Return the channels (recording, time, sensor) forecast from the first fifth of the measured ones."""
    positions = [measured.index(i) if i in measured else -1 for i in range(len(sensors))]
    best: FloatArray | None = None
    least = np.full(len(batch.data), np.inf)
    for off in ((), model.switched) if model.switched else ((),):
        begun = begun_from(model, off, batch, sensors, measured, gauge, shown_of(batch.samples))
        cost = begun.cost + [model.idle.get(name, 0.0) for name in batch.names] if off else begun.cost
        hypothesis, theta, _ = without(model, off)
        system = system_of(hypothesis, theta[None], sensors, gauge.rate, tuple(positions))
        y = (respond(system, begun.states[None], batch.samples, batch.loads) + drifted(system, batch.begins))[0]
        y = y + begun.geometric
        y = np.nan_to_num(y, nan=EXPLODED, posinf=EXPLODED, neginf=-EXPLODED)
        best = y if best is None else np.where((cost < least)[:, None, None], y, best)
        least = np.minimum(least, cost)
    assert best is not None  # there is at least one choice
    return best


def begun_from(
    model: Model,
    off: tuple[int, ...],
    batch: Batch,
    sensors: tuple[Sensor, ...],
    measured: tuple[int, ...],
    gauge: Gauge,
    shown: int,
) -> Begun:
    """Return where the recordings of a ``batch`` begin, as their first ``shown`` samples tell, and what geometry adds
    from there; by a ``model`` less the candidates whose numbers are ``off``.
    """
    hypothesis, theta, size = without(model, off)
    positions = tuple(measured.index(i) if i in measured else -1 for i in range(len(sensors)))
    (own,) = columns_of((batch.first(shown),), measured)
    geometric = np.zeros(batch.recorded.shape)
    for _ in range(1 if hypothesis.plant.geometry is None else ROUNDS):
        straight = own.less(geometric[:, :shown][..., list(measured)])
        states, cost = initial_states(hypothesis, theta, size, straight, gauge)
        geometric = added(hypothesis, theta, states, batch, sensors, gauge.rate, positions)
    return Begun(states, cost, geometric)


def without(model: Model, off: tuple[int, ...]) -> tuple[Hypothesis, FloatArray, FloatArray]:
    """Return hypothesis, theta and size of initial states of a model less the candidates whose numbers are ``off``."""
    hypothesis = model.hypothesis
    return hypothesis.less(off), model.theta[hypothesis.parameters_of(off)], model.size[hypothesis.states_of(off)]


def initial_states(
    hypothesis: Hypothesis, theta: FloatArray, size: FloatArray, batch: Batch, gauge: Gauge
) -> tuple[FloatArray, FloatArray]:
    """Return the most probable states (recording, state) given the fitted channels of a ``batch``, and their costs.

    Prior: each entry normal with standard deviation ``size``.
    """
    system = system_of(hypothesis, theta[None], gauge.sensors, gauge.rate, gauge.positions)
    if system.is_linear:
        return _linear_states(system, size, batch, gauge)
    linear = replace(system, B=system.B[:, :, :0], D=system.D[:, :, :0], forces=(), G=system.G[:, :0])
    states, cost = _linear_states(linear, size, batch.first(_samples(GROWTH[0], batch)), gauge)
    thetas = np.repeat(theta[None], len(size) + 1, axis=0)  # a copy for each entry of a state that moves, and one
    copies = system_of(hypothesis, thetas, gauge.sensors, gauge.rate, gauge.positions)
    for share in GROWTH:
        states, cost = _states_under_laws(copies, size, batch.first(_samples(share, batch)), gauge, states)
    return states, cost


def _samples(share: float, batch: Batch) -> int:
    return max(round(share * batch.samples), 2)


def _linear_states(system: System, size: FloatArray, batch: Batch, gauge: Gauge) -> tuple[FloatArray, FloatArray]:
    """Return what `initial_states` does, of a linear system: by least squares."""
    recordings, samples, _ = batch.data.shape
    weight = batch.weights(gauge)  # (recording or one row, value)
    free = batch.data - given(system, batch)[0]
    shown = observability(system, samples)[0].reshape(-1, len(size))
    wanted = (free.reshape(recordings, -1) - drift(system, samples)[0].ravel()) * weight
    precision = np.stack([(shown.T * square) @ shown for square in weight**2]) + np.diag(size**-2.0)
    states = np.linalg.solve(precision, ((wanted * weight) @ shown)[..., None])[..., 0]
    return states, np.sum((wanted - states @ shown.T * weight) ** 2, axis=1) + np.sum((states / size) ** 2, axis=1)


def _states_under_laws(
    copies: System, size: FloatArray, batch: Batch, gauge: Gauge, states: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what `initial_states` does, of force laws, from ``states``: by Levenberg and Marquardt's steps.

    ``copies``: the system, once and once more for each entry of a state, which finite differences move.
    """
    recordings = len(states)
    weight = batch.weights(gauge)  # (recording or one row, value)
    wanted = batch.data.reshape(recordings, -1) * weight
    cost, damping = np.full(recordings, np.inf), np.full(recordings, DAMPING[0])
    X, residual, trial = np.zeros((recordings, wanted.shape[1], len(size))), wanted, states
    for _ in range(ITERATIONS):
        start = np.repeat(trial[None], len(size) + 1, axis=0)
        start[1:] += np.diag(STEP * size)[:, None]
        y = respond(copies, start, batch.samples, batch.loads) + drifted(copies, batch.begins)
        y = y.reshape(len(start), recordings, -1) * weight
        y = np.nan_to_num(y, nan=EXPLODED, posinf=EXPLODED, neginf=-EXPLODED)
        left = wanted - y[0]
        new = np.sum(left**2, axis=1) + np.sum((trial / size) ** 2, axis=1)
        better = new < cost
        slopes = ((y[1:] - y[0]) / (STEP * size)[:, None, None]).transpose(1, 2, 0)
        states, cost = np.where(better[:, None], trial, states), np.minimum(cost, new)
        X = np.where(better[:, None, None], slopes, X)
        residual = np.where(better[:, None], left, residual)
        damping = np.where(better, damping / DAMPING[1], damping * DAMPING[1])
        H = np.einsum("rvs,rvt->rst", X, X, optimize=True) + np.diag(size**-2.0)
        H = H + damping[:, None, None] * np.einsum("rss->rs", H)[:, :, None] * np.eye(len(size))
        g = np.einsum("rvs,rv->rs", X, residual) - states / size**2
        step = np.linalg.solve(H, g[..., None])[..., 0]
        if np.all(np.sum(g * step, axis=1) < ENOUGH):
            break
        trial = states + step
    return states, cost


def _one(
    model: Model, batch: Batch, sensors: tuple[Sensor, ...], measured: tuple[int, ...], gauge: Gauge
) -> tuple[FloatArray, FloatArray, float, float]:
    first = shown_of(batch.samples)
    y = predicted(model, batch, sensors, measured, gauge)[:, first:]
    data = batch.recorded[:, first:]
    span = np.maximum(np.ptp(data, axis=1), 1e-30)  # (recording, sensor)
    square = np.mean((y - data) ** 2, axis=1)
    own = list(measured)
    noise = columns_of((batch,), measured)[0].sigma(gauge)[:, 0]  # (recording or one row, sensor)
    sigma = np.full((len(noise), len(sensors)), np.nan)
    sigma[:, own] = noise
    leverage = np.stack([_leverage(model, batch, sensors, measured, row, gauge.rate) for row in noise])
    floor = sigma * np.sqrt(batch.share + leverage.mean(axis=1)) / span
    energy = float(np.sum(square[:, own] / noise**2)) * data.shape[1]
    floor_energy = float(np.sum(batch.share + leverage[..., own])) * len(data) / len(noise)
    return np.sqrt(square) / span, floor, energy, floor_energy


def _leverage(
    model: Model,
    batch: Batch,
    sensors: tuple[Sensor, ...],
    measured: tuple[int, ...],
    noise: FloatArray,
    rate: float,
) -> FloatArray:
    """Return the variance (time, sensor) that the uncertain initial state adds, over that of the measured ``noise``."""
    hypothesis, theta, size = without(model, tuple(range(len(model.hypothesis.candidates))))
    positions = tuple(measured.index(i) if i in measured else -1 for i in range(len(sensors)))
    rows = observability(system_of(hypothesis, theta[None], sensors, rate, positions), batch.samples)[0]
    sigma, first = np.ones(len(sensors)), shown_of(batch.samples)
    sigma[list(measured)] = noise
    rows = rows / sigma[:, None]
    X = rows[:first, list(measured)].reshape(-1, rows.shape[-1])
    covariance = np.linalg.inv(X.T @ X + np.diag(size**-2.0))
    return np.asarray(np.einsum("tsn,nm,tsm->ts", rows[first:], covariance, rows[first:], optimize=True))
