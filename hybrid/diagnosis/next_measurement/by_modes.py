"""What to measure next by the search by modes: a further sensor, which shows one more entry of each mode's shape.

The entry z over the mode's reference entry is predicted by each claim with its slopes by theta; the posterior of theta,
errors that any model has, what differs between recordings, and identification, as good as at the other sensors, say how
far it may be off.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import solve_triangular

from fe_models.arrays import FloatArray, IntArray
from fe_models.recordings import QUANTITIES, Sensor
from hybrid.diagnosis.modal.config import FIT
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import SHAPE, shapes_in
from hybrid.diagnosis.modal.predicted_modes import predicted_modes
from hybrid.diagnosis.next_measurement.hypotheses import rivals_among
from hybrid.diagnosis.next_measurement.information import Prediction
from hybrid.diagnosis.next_measurement.measurements import Measurement, possible_sensors
from hybrid.diagnosis.next_measurement.recommendation import SENSORS, NextMeasurement, Predicted, recommended
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs


@dataclass(frozen=True, eq=False)
class Entries:
    """What a claim expects of the shapes at further sensors: Re and Im, ``mean`` (pair, 2, sensor), and how they move
    with what it leaves open, ``spread`` (pair, 2, sensor, combination).
    """

    mean: FloatArray
    spread: FloatArray


@dataclass(frozen=True, eq=False)
class Shared:
    """Pairs that all claims have: ``recording``, ``measured`` mode there, ``reference`` sensor (pair,), and the
    structure's ``mode`` (claim, pair) that each claim takes it for.
    """

    recording: IntArray
    measured: IntArray
    reference: IntArray
    mode: IntArray

    @staticmethod
    def of(fits: Sequence[ModalFit]) -> "Shared":
        """Return those of the ``fits``, with the references of the first."""
        known = [
            dict(zip(zip(own.recording.tolist(), own.measured.tolist(), strict=True), own.mode.tolist(), strict=True))
            for own in (fit.pairs for fit in fits)
        ]
        first = fits[0].pairs
        rows = [
            row
            for row, pair in enumerate(zip(first.recording.tolist(), first.measured.tolist(), strict=True))
            if all(pair in own for own in known)
        ]
        recording, measured = first.recording[rows], first.measured[rows]
        pairs = list(zip(recording.tolist(), measured.tolist(), strict=True))
        mode = np.array([[own[pair] for pair in pairs] for own in known], dtype=np.int64).reshape(len(fits), len(rows))
        return Shared(recording, measured, first.reference[rows], mode)


def next_by_modes(
    measured: ModalData, fits: Sequence[ModalFit], probability: FloatArray, present: tuple[Sensor, ...]
) -> NextMeasurement | None:
    """Return what to measure next to tell claims apart, by their ``fits``, best first, and their ``probability``; None
    where the best one has no rival. ``present``: all sensors, also those that are never fitted.
    """
    if not fits[0].claim.hypothesis.candidates:
        return None
    rivals = rivals_among([fit.claim.hypothesis.candidates for fit in fits], probability)
    if rivals is None:
        return None
    kept = [fits[number] for number in rivals.numbers]
    predicted = dict[Measurement, Predicted]()
    added = _offered(measured, present)
    shared = Shared.of(kept)
    if len(kept) > 1 and added and len(shared.recording):
        entries = [_entries(measured, fit, added, shared, number) for number, fit in enumerate(kept)]
        known = [own for own in entries if own is not None]
        if len(known) == len(kept):
            lower = np.asarray(np.linalg.cholesky(_noise(measured, kept[0].sizes, shared)), dtype=np.float64)
            for number, sensor in enumerate(added):
                item = Measurement.by(sensor)
                predicted[item] = partial(_predictions, known, number, lower)
    return recommended(rivals, predicted, SENSORS)


def _offered(measured: ModalData, present: tuple[Sensor, ...]) -> tuple[Sensor, ...]:
    """Return a sensor for each translation that has none, of what most of the present ones sense: of a mode's shape all
    quantities show the same.
    """
    have = {(sensor.node, sensor.direction) for sensor in present}
    every = [s for s in possible_sensors(measured.nominal, present) if (s.node, s.direction) not in have]
    usual = Counter(sensor.quantity for sensor in present)
    best = max({s.quantity for s in every}, key=lambda quantity: usual[quantity], default=None)
    return tuple(sensor for sensor in every if sensor.quantity == best)


def _entries(
    measured: ModalData, fit: ModalFit, added: tuple[Sensor, ...], shared: Shared, number: int
) -> Entries | None:
    """Return what claim ``number`` expects of ``added`` sensors; None where its structure does not stand."""
    sensors = (*measured.sensors, *added)
    outputs = SensorOutputs(sensors, measured.rate, (*range(len(measured.sensors)), *[-1] * len(added)))
    squares, turns = np.linalg.eigh(fit.covariance)
    root = turns * np.sqrt(np.maximum(squares, 0.0))
    mean = np.zeros((len(shared.recording), 2, len(added)))
    spread = np.zeros((*mean.shape, root.shape[1]))
    for idle in dict.fromkeys(fit.claim.idle_in(int(recording)) for recording in shared.recording):
        here = np.array([fit.claim.idle_in(int(recording)) == idle for recording in shared.recording], dtype=bool)
        hypothesis, kept = fit.claim.hypothesis.less(idle), fit.claim.hypothesis.parameters_of(idle)
        steps = FIT.difference_step * hypothesis.width
        thetas = np.vstack([fit.theta[kept], fit.theta[kept] + np.diag(steps)])
        modes = predicted_modes(hypothesis, thetas, outputs, hardly_differ=True)
        if modes is None or modes.roots.shape[1] <= shared.mode[number, here].max():
            return None
        values = modes.values_over(shared.mode[number, here], shared.reference[here])
        own = shapes_in(values)[..., len(measured.sensors) :]  # (variant, pair, sensor)
        own = np.stack([own.real, own.imag], axis=2)
        orders = measured.orders[shared.reference[here]]  # a shape is one of displacements, whatever sensors show
        log_omega = modes.log_omega[0, shared.mode[number, here]]
        own = own * np.exp(-log_omega * (QUANTITIES.index(added[0].quantity) - orders))[:, None, None]
        slopes = (own[1:] - own[0]) / steps[:, None, None, None]
        mean[here] = own[0]
        spread[here] = np.einsum("pkqs,pc->kqsc", slopes, root[kept])
    return Entries(mean, spread)


def _noise(measured: ModalData, sizes: ErrorSizes, shared: Shared) -> FloatArray:
    """Return the covariance (pair times 2, same) of Re and Im of a further entry: of errors that a mode's entry has in
    all recordings, and of those in each.
    """
    pairs, sensors = len(shared.recording), len(measured.sensors)
    own = np.zeros((pairs, 2))
    for row in range(pairs):
        modes = measured.recordings[shared.recording[row]]
        reference = np.zeros(modes.count, dtype=int)
        reference[shared.measured[row]] = shared.reference[row]
        covariance = modes.values_over(reference).covariance[shared.measured[row]]
        variances = np.diagonal(covariance)[SHAPE].reshape(2, sensors)
        others = np.arange(sensors) != shared.reference[row]  # the reference itself is one, without error
        own[row] = np.median(variances[:, others], axis=1) if others.any() else variances[:, 0]
    own += np.square([sizes.shape_varies, sizes.phase_varies])
    same = shared.mode[0][:, None] == shared.mode[0]
    common = np.einsum("kl,q->kql", same, np.square([sizes.shape, sizes.phase]))
    found = np.zeros((pairs, 2, pairs, 2))
    for part in range(2):
        found[:, part, :, part] = common[:, part]
    return np.diag(own.ravel()) + found.reshape(2 * pairs, 2 * pairs)


def _predictions(known: Sequence[Entries], sensor: int, lower: FloatArray) -> list[Prediction]:
    """Return what each claim predicts of one sensor, in units of the noise, whose Cholesky factor is ``lower``."""
    found = []
    for own in known:
        mean, spread = own.mean[..., sensor].ravel(), own.spread[:, :, sensor].reshape(own.mean[..., 0].size, -1)
        white = solve_triangular(lower, np.column_stack([mean, spread]), lower=True)
        found.append(Prediction(white[:, 0], white[:, 1:]))
    return found
