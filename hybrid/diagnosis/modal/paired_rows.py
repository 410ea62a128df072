"""What a claim leaves of the measured modes, a value a row: which mode is which, residuals, slopes and errors."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import BoolArray, FloatArray, IntArray
from hybrid.diagnosis.modal.claim import Claim, Measured
from hybrid.diagnosis.modal.config import FIT, OUTLIER, PAIRING
from hybrid.diagnosis.modal.errors import Rows
from hybrid.diagnosis.modal.pairing import displaced, paired
from hybrid.diagnosis.modal.predicted_modes import PredictedModes, predicted_modes

Inflation = Mapping[tuple[int, int], tuple[float, float, float]]
"""By recording and measured mode: how much larger than they say errors of frequency, damping ratio and shape are."""


@dataclass(frozen=True)
class Pairs:
    """Which measured mode is which: ``recording``, the ``measured`` mode there and the structure's ``mode`` (row,) of
    each pair, and ``reference`` (row,), the sensor over which shapes are taken.
    """

    recording: IntArray
    measured: IntArray
    mode: IntArray
    reference: IntArray

    def __len__(self) -> int:
        return len(self.mode)

    def are_among(self, others: "Pairs") -> BoolArray:
        """Return of which pairs (pair,) the measured mode is in another's, too."""
        known = set(zip(others.recording.tolist(), others.measured.tolist(), strict=True))
        own = zip(self.recording.tolist(), self.measured.tolist(), strict=True)
        return np.array([place in known for place in own], dtype=bool)

    def among(self, others: "Pairs") -> "Pairs":
        """Return those pairs of which the measured mode is in another's, too."""
        return self.take(self.are_among(others))

    def take(self, kept: BoolArray) -> "Pairs":
        """Return some of the pairs, those that are ``kept`` (pair,)."""
        return Pairs(self.recording[kept], self.measured[kept], self.mode[kept], self.reference[kept])


def predicted_by(measured: Measured, claim: Claim, theta: FloatArray) -> dict[tuple[int, ...], PredictedModes] | None:
    """Return the modes and their slopes, a variant a parameter after the first, by the candidates that do not act."""
    found = {}
    for off in dict.fromkeys(claim.off(recording) for recording in range(len(measured.recordings))):
        hypothesis, kept = claim.hypothesis.less(off), claim.hypothesis.parameters_of(off)
        own = theta[kept]
        thetas = np.vstack([own, own + np.diag(FIT.difference_step * hypothesis.width)])
        modes = predicted_modes(hypothesis, thetas, measured.outputs, hardly_differ=True)
        if modes is None or not modes.roots.shape[1]:
            return None
        found[off] = modes
    return found


def pairs_of(measured: Measured, claim: Claim, predicted: dict[tuple[int, ...], PredictedModes]) -> Pairs:
    """Return which measured mode is which of those predicted."""
    found: list[tuple[int, int, int]] = []
    for recording, own in enumerate(measured.recordings):
        modes = predicted[claim.off(recording)]
        mode = paired(own, modes.log_omega[0], modes.shapes[0], measured.orders)
        found += [(recording, int(k), int(mode[k])) for k in np.flatnonzero(mode >= 0)]
    rows = np.array(found, dtype=int).reshape(-1, 3)
    first = predicted[next(iter(predicted))]
    displaced = first.shapes[0] * np.exp(-np.outer(first.log_omega[0], measured.orders))
    largest = np.argmax(np.abs(displaced), axis=1)
    number = np.minimum(rows[:, 2], len(largest) - 1)  # a cause may bring a mode that others do not have
    every = Pairs(rows[:, 0], rows[:, 1], rows[:, 2], largest[number])
    return every.take(_move_at_reference(measured, every))


def _move_at_reference(measured: Measured, pairs: Pairs) -> BoolArray:
    """Return of which pairs (pair,) the measured shape moves where shapes are taken over: see `PairingConfig`."""
    found = np.ones(len(pairs), dtype=bool)
    for recording, own in enumerate(measured.recordings):
        here = np.flatnonzero(pairs.recording == recording)
        shapes = np.abs(displaced(own.log_omega, own.shapes, measured.orders))[pairs.measured[here]]
        at = shapes[np.arange(len(here)), pairs.reference[here]]
        found[here] = at > PAIRING.min_reference * shapes.max(axis=1, initial=0.0)
    return found


def values_of(measured: Measured, pairs: Pairs) -> tuple[FloatArray, FloatArray]:
    """Return what was measured of each pair (pair, 2 + 2 sensor), and its covariance (pair, same, same)."""
    sensors = len(measured.sensors)
    values = np.zeros((len(pairs), 2 + 2 * sensors))
    noise = np.zeros((len(pairs), 2 + 2 * sensors, 2 + 2 * sensors))
    for recording, own in enumerate(measured.recordings):
        here = np.flatnonzero(pairs.recording == recording)
        reference = np.zeros(len(own.log_omega), dtype=int)
        reference[pairs.measured[here]] = pairs.reference[here]
        every, covariance = own.over(reference)
        values[here], noise[here] = every[pairs.measured[here]], covariance[pairs.measured[here]]
    return values, noise


def free_values(measured: Measured, pairs: Pairs) -> BoolArray:
    """Return which values (pair, 2 + 2 sensor) say something: not the reference entries."""
    sensors = len(measured.sensors)
    free = np.ones((len(pairs), 2 + 2 * sensors), dtype=bool)
    for part in (2, 2 + sensors):
        free[np.arange(len(pairs)), part + pairs.reference] = False
    return free


def residual_of(
    measured: Measured,
    claim: Claim,
    pairs: Pairs,
    values: FloatArray,
    predicted: dict[tuple[int, ...], PredictedModes],
) -> tuple[FloatArray, FloatArray]:
    """Return what is measured less what is predicted (row,), and the slopes of that prediction (row, parameter)."""
    hypothesis = claim.hypothesis
    residual, slopes = np.zeros_like(values), np.zeros((*values.shape, len(hypothesis.centre)))
    for off, modes in predicted.items():
        here = np.array([claim.off(recording) == off for recording in pairs.recording], dtype=bool)
        if not here.any():
            continue
        kept = hypothesis.parameters_of(off)
        every = modes.over(pairs.mode[here], pairs.reference[here])  # (variant, pair, value)
        residual[here] = values[here] - every[0]
        moved = FIT.difference_step * hypothesis.less(off).width
        own = ((every[1:] - every[0]) / moved[:, None, None]).transpose(1, 2, 0)
        rows = np.zeros((*own.shape[:2], len(hypothesis.centre)))
        rows[..., kept] = own
        slopes[here] = rows
    free = free_values(measured, pairs)
    return residual[free], slopes[free]


def rows_of(
    measured: Measured,
    claim: Claim,
    pairs: Pairs,
    noise: FloatArray,
    slopes: FloatArray,
    inflation: Inflation | None = None,
) -> Rows:
    """Return all rows with their errors; ``inflation`` of those of measured modes, none of any that is not in it."""
    hypothesis = claim.hypothesis
    sensors, free = len(measured.sensors), free_values(measured, pairs)
    quantity = np.broadcast_to([0, 1] + [2] * sensors + [3] * sensors, free.shape)[free]
    place = np.broadcast_to(np.arange(free.shape[1]), free.shape)[free]
    mode = np.broadcast_to(pairs.mode[:, None], free.shape)[free]
    recording = np.broadcast_to(pairs.recording[:, None], free.shape)[free]
    shared = np.unique(mode * free.shape[1] + place, return_inverse=True)[1]
    whole = np.zeros((len(quantity), len(quantity)))
    begin = 0
    for own, covariance in zip(free, noise, strict=True):
        end = begin + int(own.sum())
        whole[begin:end, begin:end] = covariance[np.ix_(own, own)]
        begin = end
    return Rows(
        quantity,
        mode,
        shared,
        recording,
        whole,
        slopes,
        hypothesis.width[: hypothesis.nuisances],
        measured.kind,
        np.isin(recording, claim.changed),
        _by_value(inflation or {}, pairs, free)[free],
    )


def _by_value(inflation: Inflation, pairs: Pairs, free: BoolArray) -> FloatArray:
    """Return the inflation of each value (pair, 2 + 2 sensor)."""
    found = np.ones(free.shape)
    for row, key in zip(found, zip(pairs.recording.tolist(), pairs.measured.tolist(), strict=True), strict=True):
        if key in inflation:
            row[:2], row[2:] = inflation[key][:2], inflation[key][2]
    return found


def log_density_of_outliers(measured: Measured, pairs: Pairs) -> float:
    """Return the log density of the measured modes that no mode of the structure is, and the prior of all."""
    entries = len(measured.sensors) - 1  # beside that of reference
    widths = outlying_by(np.array([0, 1] + [2] * entries + [3] * entries))
    each = -float(np.sum(np.log(widths))) - 0.5 * len(widths) * float(np.log(2 * np.pi * np.e))
    alone = measured.modes - len(pairs)
    return alone * (each + float(np.log(OUTLIER.probability))) + len(pairs) * float(np.log1p(-OUTLIER.probability))


def outlying_by(quantity: IntArray) -> FloatArray:
    """Return by how much rows are off, by their ``quantity`` (row,), that are of no mode of the structure."""
    return np.array([OUTLIER.log_frequency, OUTLIER.damping_ratio, OUTLIER.shape, OUTLIER.shape])[quantity]


def predicted_of(
    measured: Measured, claim: Claim, theta: FloatArray
) -> tuple[dict[tuple[int, ...], PredictedModes], Pairs]:
    """Return a claim's modes at ``theta`` (parameter,), by the candidates that do not act, and which measured one is
    which of them; none where the structure does not stand.
    """
    predicted = predicted_by(measured, claim, theta)
    if predicted is None:
        return {}, Pairs(*np.zeros((4, 0), dtype=int))
    return predicted, pairs_of(measured, claim, predicted)
