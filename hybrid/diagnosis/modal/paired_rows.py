"""What a claim leaves of the measured modes, a value a row: residuals, slopes and errors."""

import numpy as np

from fe_models.arrays import BoolArray, FloatArray, IntArray
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.config import FIT, LISTED, UNPAIRED
from hybrid.diagnosis.modal.inflation import NOT_INFLATED, Inflation
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import (
    FREQUENCY,
    RATIO,
    SHAPE,
    ModeValues,
    free_values,
    quantities_of,
    value_count,
)
from hybrid.diagnosis.modal.modes_of_claim import Predicted
from hybrid.diagnosis.modal.pairs import Pairs
from hybrid.diagnosis.modal.rows import Rows


def values_of(measured: ModalData, pairs: Pairs) -> ModeValues:
    """Return what was measured of each pair, over its reference."""
    size = value_count(len(measured.sensors))
    values, covariance = np.zeros((len(pairs), size)), np.zeros((len(pairs), size, size))
    for recording, own in enumerate(measured.recordings):
        here = np.flatnonzero(pairs.recording == recording)
        known = own.values_over(pairs.references_in(recording, own.count)).take(pairs.measured[here])
        values[here], covariance[here] = known.values, known.covariance
    return ModeValues(values, covariance)


def residual_of(
    measured: ModalData,
    claim: Claim,
    pairs: Pairs,
    values: FloatArray,
    predicted: Predicted,
) -> tuple[FloatArray, FloatArray]:
    """Return what is measured, ``values`` (pair, value), less what is ``predicted`` (row,), and the slopes of that
    prediction (row, parameter).
    """
    hypothesis = claim.hypothesis
    residual, slopes = np.zeros_like(values), np.zeros((*values.shape, len(hypothesis.centre)))
    for idle, modes in predicted.items():
        here = np.array([claim.idle_in(recording) == idle for recording in pairs.recording], dtype=bool)
        if not here.any():
            continue
        kept = hypothesis.parameters_of(idle)
        every = modes.values_over(pairs.mode[here], pairs.reference[here])  # (variant, pair, value)
        residual[here] = values[here] - every[0]
        moved = FIT.difference_step * hypothesis.less(idle).width
        own = ((every[1:] - every[0]) / moved[:, None, None]).transpose(1, 2, 0)
        rows = np.zeros((*own.shape[:2], len(hypothesis.centre)))
        rows[..., kept] = own
        slopes[here] = rows
    free = free_values(pairs.reference, len(measured.sensors))
    return residual[free], slopes[free]


def rows_of(
    measured: ModalData,
    claim: Claim,
    pairs: Pairs,
    noise: FloatArray,
    slopes: FloatArray,
    inflation: Inflation | None = None,
) -> Rows:
    """Return all rows with their errors: ``noise`` (pair, value, value), the covariance of what was measured, with its
    ``inflation``; ``slopes`` (row, nuisance).
    """
    hypothesis, free = claim.hypothesis, free_values(pairs.reference, len(measured.sensors))
    quantity = np.broadcast_to(quantities_of(len(measured.sensors)), free.shape)[free]
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
        measured.correlation_root,
        measured.kinds,
        np.isin(recording, claim.changed),
        _by_value(inflation or {}, pairs, free)[free],
    )


def _by_value(inflation: Inflation, pairs: Pairs, free: BoolArray) -> FloatArray:
    """Return the inflation of each value (pair, value)."""
    found = np.ones(free.shape)
    for row, place in zip(found, pairs.places, strict=True):
        own = inflation.get(place, NOT_INFLATED)
        row[FREQUENCY], row[RATIO], row[SHAPE] = own.frequency, own.ratio, own.shape
    return found


def log_density_of_unpaired(measured: ModalData, pairs: Pairs) -> float:
    """Return the log density of the measured modes that no mode of the structure is, and the prior of all."""
    known = set(pairs.places)
    have_shapes = [
        bool(own.has_shape[mode])
        for recording, own in enumerate(measured.recordings)
        for mode in range(own.count)
        if (recording, mode) not in known
    ]
    widths = unpaired_widths(quantities_of(len(measured.sensors) - 1))  # the entry of reference is not free
    without_shape = widths.copy()
    without_shape[SHAPE] = LISTED.any_shape  # as of a pair
    total = len(pairs) * float(np.log1p(-UNPAIRED.probability))
    for has_shape, own in ((True, widths), (False, without_shape)):
        each = -float(np.sum(np.log(own))) - 0.5 * len(own) * float(np.log(2 * np.pi * np.e))
        total += have_shapes.count(has_shape) * (each + float(np.log(UNPAIRED.probability)))
    return total


def unpaired_widths(quantity: IntArray) -> FloatArray:
    """Return by how much rows are off, by their ``quantity`` (row,), that are of no mode of the structure."""
    return np.array([UNPAIRED.log_frequency, UNPAIRED.damping_ratio, UNPAIRED.shape, UNPAIRED.shape])[quantity]
