"""What hypotheses of the search by time series expect of a further sensor, in recordings like those there are.

What the present sensors leave open of parameters and initial states follows from the fit and from the slopes of their
channels; what the further sensor shows of that, and of the best fits, from the slopes of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Sensor
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.next_measurement.config import SAMPLES
from hybrid.diagnosis.next_measurement.information import Prediction
from hybrid.diagnosis.next_measurement.motion import Motion, NearFit
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs


@dataclass(frozen=True)
class Surroundings:
    """The ``noise_model`` of the present sensors; ``temper``: what log evidences are divided by, and ``widened``: what
    variances of parameters grow by (see `Posterior`).
    """

    noise_model: NoiseModel
    temper: float
    widened: float

    def outputs(self, added: tuple[Sensor, ...] = ()) -> SensorOutputs:
        """Return the present sensors, and ``added`` ones behind them, which have no faults."""
        present = self.noise_model.sensors
        return SensorOutputs((*present, *added), self.noise_model.rate, (*range(len(present)), *[-1] * len(added)))

    def open_in(self, item: Fit) -> FloatArray:
        """Return what a fit leaves open of its parameters, L (parameter, combination) of their covariance L L^T."""
        squares, turns = np.linalg.eigh(self.widened * item.covariance)
        return np.asarray(turns * np.sqrt(np.maximum(squares, 0.0)))


@dataclass(frozen=True, eq=False)
class Expected:
    """What a hypothesis expects of further sensors in one recording, at some samples: ``mean`` (time, sensor), and what
    it leaves open by its parameters, ``by_theta`` (time, sensor, combination), and by this recording's initial state,
    ``by_state`` (time, sensor, combination).
    """

    mean: FloatArray
    by_theta: FloatArray
    by_state: FloatArray


@dataclass(frozen=True)
class Sample:
    """The recordings that are looked at, by their data, ``keys``, and every ``stride`` samples of each; each value
    there stands for ``stands_for`` recorded ones in the end.
    """

    keys: tuple[bytes, ...]
    stride: int
    compared: int
    stands_for: float

    @staticmethod
    def of(item: Fit) -> "Sample":
        """Return the sample of a fit's recordings."""
        every = [data for batch in item.batches for data in batch.data]
        kept = [every[int(i)] for i in np.linspace(0, len(every) - 1, min(SAMPLES.max_recordings, len(every))).round()]
        samples = max(len(data) for data in kept)
        stride = max(1, len(kept) * samples // SAMPLES.slopes_at)
        compared = min(-(-samples // stride), max(1, SAMPLES.compared_at // len(kept)))
        total = sum(len(data) for data in every)
        return Sample(tuple(data.tobytes() for data in kept), stride, compared, total / (compared * len(kept)))

    def times(self, number: int, samples: int) -> FloatArray:
        """Return which of the ``samples`` of the slopes of recording ``number`` are compared: drawn, as every n-th may
        fall in step with a mode.
        """
        rng = np.random.default_rng(number)
        return np.sort(rng.choice(samples, min(self.compared, samples), replace=False))


def expected_in(
    item: Fit, added: tuple[Sensor, ...], around: Surroundings, sample: Sample
) -> tuple[Expected, ...] | None:
    """Return what a fit expects of ``added`` sensors in each recording of the ``sample``; None where its motion grows
    beyond all bounds.
    """
    found = dict[bytes, Expected]()
    outputs, root = around.outputs(added), around.open_in(item)
    for batch, states in zip(item.batches, item.states, strict=True):
        rows = [row for row, data in enumerate(batch.data) if data.tobytes() in sample.keys]
        if not rows:
            continue
        near = NearFit.of(item, batch.off)
        loads = batch.loads and batch.loads.take(np.array(rows))
        motion = near.motion(outputs, states[rows][None], batch.samples, sample.stride, loads)
        if not motion.is_finite:
            return None
        noise = np.broadcast_to(batch.sigma(around.noise_model)[:, 0], (len(batch.data), len(around.noise_model.sigma)))
        free = largest_states(states, near)
        for position, row in enumerate(rows):
            key = batch.data[row].tobytes()
            times = sample.times(sample.keys.index(key), motion.mean.shape[1])
            found[key] = _expected(motion, position, times, noise[row], root[near.kept], free, around)
    return tuple(found[key] for key in sample.keys)


def _expected(
    motion: Motion,
    position: int,
    times: FloatArray,
    noise: FloatArray,
    root: FloatArray,
    free: FloatArray,
    around: Surroundings,
) -> Expected:
    """Return what is expected in the recording at a ``position`` of a motion; ``free`` (state,): how large entries of
    its initial state may be.
    """
    present = len(noise)
    by_theta, by_state = motion.by_theta[:, position], motion.by_state[position]
    weight = np.sqrt(motion.stride / around.temper) / noise  # (sensor,) of the present ones
    B = (by_state[:, :present] * weight[:, None]).reshape(-1, by_state.shape[-1])
    J = (by_theta[..., :present] * weight).reshape(len(by_theta), -1)
    known = B.T @ B + np.diag(1 / free**2)
    follows = -np.linalg.solve(known, B.T @ J.T)  # (state, parameter): how the initial state moves with theta
    own = by_state[times, present:]
    total = by_theta[:, times, present:].transpose(1, 2, 0) + own @ follows
    left = np.linalg.inv(np.linalg.cholesky(known)).T
    return Expected(motion.mean[position, times, present:], total @ root, own @ left)


def largest_states(states: FloatArray, near: NearFit) -> FloatArray:
    """Return how large each entry of an initial state (state,) may be beforehand, by the ``states`` (recording, state)
    that were found: displacements, velocities and harmonic forces for themselves.
    """
    n, sizes = near.hypothesis.size, np.sqrt(np.mean(states**2, axis=0))
    for part in (slice(0, n), slice(n, 2 * n), slice(2 * n, None)):
        sizes[part] = sizes[part].max(initial=0.0)
    return np.asarray(SAMPLES.free_state * np.maximum(sizes, np.finfo(float).tiny ** 0.25))


def predictions_of(expected: Sequence[tuple[Expected, ...]], sensor: int, noise: float) -> list[Prediction]:
    """Return what each hypothesis predicts of one of the further sensors; ``noise``: of a compared value."""
    found = []
    for recordings in expected:
        mean = np.concatenate([own.mean[:, sensor] for own in recordings])
        shared = np.concatenate([own.by_theta[:, sensor] for own in recordings])
        states = [own.by_state[:, sensor] for own in recordings]
        spread = np.zeros((len(mean), shared.shape[1] + sum(part.shape[1] for part in states)))
        spread[:, : shared.shape[1]] = shared
        row, column = 0, shared.shape[1]
        for part in states:
            spread[row : row + len(part), column : column + part.shape[1]] = part
            row, column = row + len(part), column + part.shape[1]
        found.append(Prediction(mean / noise, spread / noise))
    return found
