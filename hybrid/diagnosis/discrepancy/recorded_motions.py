"""Recordings as a filter follows them: each motion with its noise, beside the modes that a claim expects of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from hybrid.diagnosis.discrepancy.config import DISCREPANCY
from hybrid.diagnosis.discrepancy.expected_modes import Expectation, ExpectedModes, MotionClaim, expectation_of
from hybrid.diagnosis.discrepancy.following import followed, likeliest_discrepancy
from hybrid.diagnosis.discrepancy.size import START
from hybrid.diagnosis.discrepancy.tracking import Track, tracked, with_less_discrepancy
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import SHAPE, free_values
from hybrid.diagnosis.nominal.lowpass import noise_is_lowpassed
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.batches import batches_of, columns_of, measured_columns
from hybrid.diagnosis.recorded.noise import noise_of_recordings, structure_band
from hybrid.diagnosis.recorded.noise_levels import NoiseLevels


@dataclass(frozen=True, eq=False)
class RecordedMotion:
    """A motion of the training ``recording`` with that number: ``data`` (time, sensor) of the measured channels, and
    the variance of their ``noise`` (sensor,).
    """

    recording: int
    data: FloatArray
    noise: FloatArray


def recorded_motions(dataset: Dataset, measured: ModalData) -> list[RecordedMotion]:
    """Return all motions of the training recordings, in order."""
    columns = measured_columns(dataset)
    numbers = [number for number, recording in enumerate(dataset.select("train")) for _ in recording.data]
    found = dict[int, RecordedMotion]()
    usual, levels = noise_in(dataset, measured)
    for batch in columns_of(batches_of(dataset, "train"), columns):
        each = np.ones((len(batch.names), len(columns))) if levels.are_alike else levels.of_recordings(batch)
        for order, data, own in zip(batch.order, batch.data, each, strict=True):
            found[order] = RecordedMotion(numbers[order], np.ascontiguousarray(data), (usual * own) ** 2)
    return [found[order] for order in sorted(found)]


def noise_in(dataset: Dataset, measured: ModalData) -> tuple[FloatArray, NoiseLevels]:
    """Return the usual noise (sensor,) of the recordings for training, and how it differs between them."""
    rate = dataset.sampling_rate
    band = structure_band(measured.nominal, rate, dataset.lowpass, white=not noise_is_lowpassed(dataset))
    batches = columns_of(batches_of(dataset, "train"), measured_columns(dataset))
    levels = NoiseLevels.of(batches, rate, band)
    return noise_of_recordings(batches, rate, band) if levels.are_alike else np.exp(levels.usual), levels


def track_of(dataset: Dataset, measured: ModalData, fit: ModalFit, sizes: ErrorSizes | None = None) -> Track | None:
    """Return all motions as a fit's claim expects them, with the most probable discrepancy; None where the structure
    has no modes there. ``sizes``: see `MotionClaim`.
    """
    recorded = recorded_motions(dataset, measured)
    claimed = MotionClaim(measured, fit, 1 / dataset.sampling_rate, tuple(own.recording for own in recorded), sizes)
    expected = expectation_of(claimed)
    if expected is None:
        return None
    if sizes is None:  # its modes are where the recordings have them
        expected = as_identified(measured, fit, expected)
    spaces = [modes.space for modes in expected.modes]
    motions = parallel_map(
        lambda pair: followed(pair[0], pair[1].data, pair[1].noise), list(zip(spaces, recorded, strict=True))
    )
    discrepancy = likeliest_discrepancy(list(zip(spaces, motions, strict=True)), START, DISCREPANCY.factors)
    return with_less_discrepancy(tracked(claimed, expected, motions, discrepancy))


def as_identified(measured: ModalData, fit: ModalFit, expected: Expectation) -> Expectation:
    """Return the modes moved by what any model gets wrong of them, as the modes of all recordings have it."""
    rows = fit.rows
    common, sharing = rows.common(fit.sizes), rows.sharing
    alike = common * (sharing @ (sharing.T @ (common * fit.weighed)))
    each = alike / (sharing @ sharing.sum(axis=0))  # every row of a shared error has all of it
    return expected.moved_by(_by_value(measured, fit, expected.modes[0], each))


def errors_of_state(measured: ModalData, fit: ModalFit, modes: ExpectedModes, recordings: Sequence[int]) -> FloatArray:
    """Return how far the values (value,) of all modes in some ``recordings`` of one state are, on average, from where
    the claim has them beside what is wrong in all.
    """
    own = fit.rows.varying(fit.sizes) ** 2 * fit.weighed * np.isin(fit.rows.recording, recordings)
    return _by_value(measured, fit, modes, own / max(len(recordings), 1))


def _by_value(measured: ModalData, fit: ModalFit, modes: ExpectedModes, by_row: FloatArray) -> FloatArray:
    """Return the sums of what rows (row,) have of each value (value,) of the ``modes``."""
    rows, free = fit.rows, free_values(fit.pairs.reference, len(measured.sensors))
    place = np.broadcast_to(np.arange(free.shape[1]), free.shape)[free]
    own = np.flatnonzero(rows.mode < modes.space.count)
    found = np.zeros(modes.free.shape)
    np.add.at(found, (rows.mode[own], place[own]), by_row[own])
    there = fit.pairs.mode < modes.space.count
    mode, reference = fit.pairs.mode[there], fit.pairs.reference[there]
    found[mode[reference != modes.reference[mode]], SHAPE] = 0.0  # a shape over another entry
    return found[modes.free]
