"""Forecasts of recordings from their first fifth, for every model alike, and what a perfect model would score."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student

from fe_models.arrays import TINY, BoolArray, FloatArray
from hybrid.diagnosis.fitting.config import FORECAST, GEOMETRY_RESPONSE, INITIAL_STATES
from hybrid.diagnosis.fitting.geometry_response import added_motion
from hybrid.diagnosis.fitting.initial_states import initial_states, precision_of
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.recorded.batches import Batch, columns_of, count_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel, SensorRoles
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.loaded import loaded_size
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import System, drifted, is_defective, observability

Start = tuple[FloatArray, FloatArray]
"""What initial states do to channels (time, sensor, state), and their covariance (state, state)."""


@dataclass(frozen=True)
class ForecastModel:
    """A hypothesis at one ``theta`` (parameter,), and the ``spread`` of initial states: their covariance (state,
    state), as those of the training recordings show it.

    ``switched``: numbers of candidates that act in some recordings only; in each the better choice is taken, where
    ``idle`` (by name) says how much cost it adds that they do not act: see `idle_by_order`. ``bent``: hypotheses that
    differ by what geometry adds, which only motions larger than those in training may show: in each recording the one
    is taken that its first fifth asks for.
    """

    hypothesis: Hypothesis
    theta: FloatArray
    spread: FloatArray
    switched: tuple[int, ...] = ()
    idle: Mapping[str, float] = field(default_factory=dict)
    bent: tuple[Hypothesis, ...] = ()


@dataclass(frozen=True)
class ForecastScore:
    """``nrmse`` and ``floor`` (recording, sensor); ``energy`` and ``floor_energy``: of the measured channels' errors,
    in units of the noise's variance, of the model and of a perfect one; ``chance``: the latter's standard deviation, by
    noise and by what initial states happen to be.
    """

    nrmse: FloatArray
    floor: FloatArray
    energy: float
    floor_energy: float
    chance: float = 0.0

    @property
    def is_perfect(self) -> bool:
        """Whether a perfect model may have such errors by chance."""
        return self.energy <= self.floor_energy + FORECAST.max_error_sigma * self.chance

    @property
    def excess(self) -> float:
        """The energy of errors beyond that of a perfect model; more than nothing, as shares of it are reported."""
        return max(self.energy - self.floor_energy, TINY)


@dataclass(frozen=True)
class InitialEstimate:
    """Initial ``states`` (recording, state), their ``cost`` (recording,), and what geometry adds to the motion from
    there, ``geometric`` (recording, time, sensor); none of a linear model.
    """

    states: FloatArray
    cost: FloatArray
    geometric: FloatArray


def shown_of(samples: int) -> int:
    """Return how many of a recording's ``samples`` its initial state is estimated from; the others are forecast."""
    return max(int(np.ceil(FORECAST.estimation_share * samples)), 2)


def model_of(item: Fit, noise_model: NoiseModel, theta: FloatArray | None = None) -> ForecastModel:
    """Return a fit's model for forecasts; the spread of initial states is that of the training recordings.

    Whatever the phase of each mode: another recording begins at another one. Of few recordings it is not known well: it
    is as much larger as Student's distribution is wider than the normal one, with two degrees of freedom of each. Under
    known loads it is that of the motion: others may begin within it, though these began at rest.
    """
    most = max(states.shape[1] for states in item.states)
    full = np.concatenate([states for states in item.states if states.shape[1] == most])
    A = system_of(item.hypothesis, item.theta[None], noise_model.outputs).A[0]
    own = _of_few(len(full)) * _at_any_phase(A, full) + np.diag(np.broadcast_to(_pushed(item, noise_model), most))
    spread = _bounded(own, item.hypothesis.size)
    return ForecastModel(item.hypothesis, item.theta if theta is None else theta, spread, switched_in(item))


def spread_of(A: FloatArray, states: FloatArray) -> FloatArray:
    """Return the covariance (state, state) of the initial states of z' = A z, displacements before velocities, as those
    of other recordings, ``states`` (recording, state), have it: see `model_of`.
    """
    return _bounded(_of_few(len(states)) * _at_any_phase(A, states), len(A) // 2)


def _of_few(recordings: int) -> float:
    """Return how much larger than that of many recordings the covariance of so few is taken."""
    quantile = FORECAST.initial_state_quantile
    return float((student(2 * recordings).ppf(quantile) / norm.ppf(quantile)) ** 2)


def _bounded(spread: FloatArray, modes: int) -> FloatArray:
    """Return a covariance (state, state) with the least that each state may vary."""
    return np.asarray(spread + np.diag(_least(np.sqrt(np.diag(spread)), modes) ** 2))


def _at_any_phase(A: FloatArray, states: FloatArray) -> FloatArray:
    """Return the covariance (state, state) of initial ``states`` (recording, state) of z' = A z, each natural mode and
    harmonic force at any phase of its turn.
    """
    vectors = np.linalg.eig(A)[1]
    if is_defective(vectors):  # a body that moves freely turns nowhere
        return np.diag(np.mean(states**2, axis=0))
    amplitudes = np.linalg.solve(vectors, states.T)  # (mode, recording)
    return np.asarray(np.real((vectors * np.mean(np.abs(amplitudes) ** 2, axis=1)) @ vectors.conj().T))


def _least(size: FloatArray, modes: int) -> FloatArray:
    """Return a millionth of the largest of the sizes (state,) of each unit: displacements and velocities of that many
    ``modes``, then two of each harmonic force.
    """
    parts = np.split(size, [modes, *range(2 * modes, len(size), 2)])
    return np.concatenate(
        [np.full(len(part), FORECAST.least_state_share * (part.max() or size.max())) for part in parts]
    )


def switched_in(item: Fit) -> tuple[int, ...]:
    """Return the numbers of a fit's candidates that act in some recordings only."""
    return tuple(sorted({number for batch in item.batches for number in batch.off}))


def idle_by_order(item: Fit, order: Sequence[str]) -> dict[str, float]:
    """Return what it adds to a recording's cost that what acts in some recordings only is idle there.

    By those fitted before and after it in the ``order`` in which they were made, where these agree: its first fifth may
    not show it (a stop that is not hit so early). Nothing where several motions share a name.
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
            found[name] = -FORECAST.order_cost if sides.pop() else FORECAST.order_cost
    return found


def _pushed(item: Fit, noise_model: NoiseModel) -> FloatArray:
    """Return the mean squares (state,) of the motion that known loads make of rest in a fit's recordings."""
    loaded = [batch for batch in item.batches if batch.loads is not None]
    system = system_of(item.hypothesis, item.theta[None], noise_model.outputs)
    sizes = [len(batch.names) * loaded_size(system, batch.loads) for batch in loaded if batch.loads is not None]
    return np.sum(sizes, axis=0) / count_of(item.batches) if sizes else np.zeros(1)


def forecast(model: ForecastModel, batches: tuple[Batch, ...], roles: SensorRoles) -> ForecastScore:
    """Return the scores over the last 80 % of the recordings, of all sensors in ``roles``."""
    return summed([_one(model, batch, roles) for batch in batches])


def summed(parts: Sequence[tuple[FloatArray, FloatArray, float, float, float]]) -> ForecastScore:
    """Return the score of all batches from the parts of each: see `scored`."""
    nrmse, floor = (np.concatenate([part[i] for part in parts]) for i in (0, 1))
    energy, floor_energy, variance = (float(sum(part[i] for part in parts)) for i in (2, 3, 4))
    return ForecastScore(nrmse, floor, energy, floor_energy, float(np.sqrt(variance)))


def joined(parts: Sequence[ForecastScore]) -> ForecastScore:
    """Return the score of all recordings of several scores, one behind the other."""
    nrmse, floor = (np.concatenate([getattr(part, word) for part in parts]) for word in ("nrmse", "floor"))
    energy, floor_energy = (float(sum(getattr(part, word) for part in parts)) for word in ("energy", "floor_energy"))
    return ForecastScore(nrmse, floor, energy, floor_energy, float(np.hypot.reduce([part.chance for part in parts])))


def predicted(model: ForecastModel, batch: Batch, roles: SensorRoles) -> FloatArray:
    """Return the channels (recording, time, sensor) forecast from the first fifth of the measured ones."""
    best: FloatArray | None = None
    least = np.full(len(batch.data), np.inf)
    far = INITIAL_STATES.max_motion_ratio * float(np.abs(batch.recorded).max())
    for own, off, begun in _ways(model, batch, roles):
        hypothesis, theta, _ = without(own, off)
        system = system_of(hypothesis, theta[None], roles.outputs)
        y = (respond(system, begun.states[None], batch.samples, batch.loads) + drifted(system, batch.begins))[0]
        y = y + begun.geometric
        y = np.nan_to_num(y, nan=far, posinf=far, neginf=-far)
        best = y if best is None else np.where((begun.cost < least)[:, None, None], y, best)
        least = np.minimum(least, begun.cost)
    assert best is not None  # there is at least one way
    return best


def is_bent(model: ForecastModel, batch: Batch, roles: SensorRoles) -> BoolArray:
    """Return which recordings (recording,) are forecast with what geometry adds, by one of the ``bent`` hypotheses."""
    least = [np.full(len(batch.data), np.inf) for _ in range(2)]
    for own, _, begun in _ways(model, batch, roles):
        bent = own.hypothesis is not model.hypothesis
        least[bent] = np.minimum(least[bent], begun.cost)
    return least[True] < least[False]


def least_cost(model: ForecastModel, off: tuple[int, ...], batch: Batch, roles: SensorRoles) -> FloatArray:
    """Return the cost (recording,) of whole recordings by a model less the candidates ``off``, bent or not."""
    return np.min([begun.cost for _, begun in _begun_by(model, off, batch, roles, batch.samples)], axis=0)


def _ways(
    model: ForecastModel, batch: Batch, roles: SensorRoles
) -> Iterator[tuple[ForecastModel, tuple[int, ...], InitialEstimate]]:
    """Yield in which ways recordings may go on after their first fifth, by which one is chosen: a model, the numbers of
    the candidates that do not act, and where it begins.
    """
    for off in ((), model.switched) if model.switched else ((),):
        idle = np.array([model.idle.get(name, 0.0) if off else 0.0 for name in batch.names])
        for own, begun in _begun_by(model, off, batch, roles, shown_of(batch.samples)):
            yield own, off, replace(begun, cost=begun.cost + idle)


def _begun_by(
    model: ForecastModel, off: tuple[int, ...], batch: Batch, roles: SensorRoles, shown: int
) -> Iterator[tuple[ForecastModel, InitialEstimate]]:
    """Yield where a model begins, and where each of its ``bent`` hypotheses does that is felt along its motion."""
    begun = begun_from(model, off, batch, roles, shown)
    yield model, begun
    sigma = columns_of((batch,), roles.measured)[0].sigma(roles.noise_model)
    for hypothesis in model.bent:
        bent = replace(model, hypothesis=hypothesis)
        own, theta, _ = without(bent, off)
        y = added_motion(own, theta, begun.states, batch, roles.outputs)[..., list(roles.measured)]
        if np.square(y / sigma).sum() > GEOMETRY_RESPONSE.min_energy_share * y.size:
            again = begun_from(bent, off, batch, roles, shown)
            yield bent, replace(again, cost=again.cost + FORECAST.min_geometry_gain)


def begun_from(
    model: ForecastModel, off: tuple[int, ...], batch: Batch, roles: SensorRoles, shown: int
) -> InitialEstimate:
    """Return where the recordings of a ``batch`` begin, as their first ``shown`` samples show, and what geometry adds
    from there; by a ``model`` less the candidates whose numbers are ``off``.
    """
    hypothesis, theta, spread = without(model, off)
    (own,) = columns_of((batch.first(shown),), roles.measured)
    states: FloatArray | None = None
    geometric = np.zeros(batch.recorded.shape)
    for _ in range(1 if hypothesis.nominal.geometry is None else FORECAST.geometry_rounds):
        straight = own.less(geometric[:, :shown][..., list(roles.measured)])
        states, cost = initial_states(hypothesis, theta, spread, straight, roles.noise_model, states)
        geometric = added_motion(hypothesis, theta, states, batch, roles.outputs)
    assert states is not None  # there was one round at least
    return InitialEstimate(states, cost, geometric)


def without(model: ForecastModel, off: tuple[int, ...]) -> tuple[Hypothesis, FloatArray, FloatArray]:
    """Return hypothesis, theta and initial states' spread of a model less the candidates whose numbers are ``off``."""
    hypothesis, kept = model.hypothesis, model.hypothesis.states_of(off)
    return hypothesis.less(off), model.theta[hypothesis.parameters_of(off)], model.spread[np.ix_(kept, kept)]


def _one(model: ForecastModel, batch: Batch, roles: SensorRoles) -> tuple[FloatArray, FloatArray, float, float, float]:
    return scored(predicted(model, batch, roles), batch, roles, lambda noise: _start(model, batch, roles, noise))


def scored(
    y: FloatArray, batch: Batch, roles: SensorRoles, start: Callable[[FloatArray], Start]
) -> tuple[FloatArray, FloatArray, float, float, float]:
    """Return the parts of a `ForecastScore` of one batch, of which ``y`` (recording, time, sensor) is forecast; the
    last part is the square of its ``chance``. ``start``: what initial states do, by the ``noise`` (sensor,): see
    `start_of`.
    """
    first = shown_of(batch.samples)
    y = y[:, first:]
    data = batch.recorded[:, first:]
    span = np.maximum(np.ptp(data, axis=1), 1e-30)  # (recording, sensor)
    square = np.mean((y - data) ** 2, axis=1)
    own = list(roles.measured)
    noise = columns_of((batch,), roles.measured)[0].sigma(roles.noise_model)[:, 0]  # (recording or one row, sensor)
    sigma = np.full((len(noise), len(roles.sensors)), np.nan)
    sigma[:, own] = noise
    starts = [start(row) for row in noise]
    levers = np.stack([_variance(*begun) for begun in starts])
    floor = sigma * np.sqrt(batch.share + levers.mean(axis=1)) / span
    each = len(data) / len(noise)
    energy = float(np.sum(square[:, own] / noise**2)) * data.shape[1]
    floor_energy = float(np.sum(batch.share + levers[..., own])) * each
    variance = sum(_chance(rows[:, own], covariance) for rows, covariance in starts) * each
    return np.sqrt(square) / span, floor, energy, floor_energy, variance + 2 * batch.share * data[..., own].size


def leverage(model: ForecastModel, batch: Batch, roles: SensorRoles, noise: FloatArray) -> FloatArray:
    """Return the variance (time, sensor) that the uncertain initial state adds, over that of the measured ``noise``."""
    return _variance(*_start(model, batch, roles, noise))


def _start(model: ForecastModel, batch: Batch, roles: SensorRoles, noise: FloatArray) -> Start:
    hypothesis, theta, spread = without(model, tuple(range(len(model.hypothesis.candidates))))
    return start_of(system_of(hypothesis, theta[None], roles.outputs), spread, batch.samples, roles, noise)


def start_of(system: System, spread: FloatArray, samples: int, roles: SensorRoles, noise: FloatArray) -> Start:
    """Return what initial states do to the channels that are forecast (time, sensor, state), in units of the ``noise``,
    and their covariance (state, state) given the first fifth.
    """
    rows = observability(system, samples)[0]
    sigma, first = np.ones(len(roles.sensors)), shown_of(samples)
    sigma[list(roles.measured)] = noise
    rows = rows / sigma[:, None]
    X = rows[:first, list(roles.measured)].reshape(-1, rows.shape[-1])
    return rows[first:], np.linalg.inv(X.T @ X + precision_of(spread))


def _variance(rows: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the variances (time, sensor) of what is linear in normal states, ``rows`` (time, sensor, state)."""
    return np.asarray(np.einsum("tsn,nm,tsm->ts", rows, covariance, rows, optimize=True))


def _chance(rows: FloatArray, covariance: FloatArray) -> float:
    """Return the variance of the sum of squares of what is linear in normal states, ``rows`` (time, sensor, state)."""
    flat = rows.reshape(-1, rows.shape[-1])
    spread = covariance @ (flat.T @ flat)
    return float(2 * np.trace(spread @ spread))
