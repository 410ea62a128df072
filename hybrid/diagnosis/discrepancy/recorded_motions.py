"""Recordings as a filter follows them: each motion with its noise, beside the modes that a claim expects of it."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from hybrid.diagnosis.discrepancy.expected_modes import expectation_of
from hybrid.diagnosis.discrepancy.tracking import Followed, Track, amplitudes_of, tracked
from hybrid.diagnosis.modal.claim import Measured
from hybrid.diagnosis.modal.errors import ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.nominal.lowpass import noise_is_lowpassed
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.batches import Batch, batches_of, columns_of, measured_columns
from hybrid.diagnosis.recorded.noise import Band, noise_of_recordings, structure_band
from hybrid.diagnosis.recorded.noise_levels import NoiseLevels


def motions_with_noise(dataset: Dataset, measured: Measured) -> list[tuple[int, FloatArray, FloatArray]]:
    """Return the number of its training recording, the measured channels (time, sensor), and the variance of their
    noise (sensor,), of each motion.
    """
    rate, columns = dataset.sampling_rate, measured_columns(dataset)
    band = structure_band(measured.nominal, rate, dataset.lowpass, white=not noise_is_lowpassed(dataset))
    numbers = [number for number, recording in enumerate(dataset.select("train")) for _ in recording.data]
    found: dict[int, tuple[int, FloatArray, FloatArray]] = {}
    batches = columns_of(batches_of(dataset, "train"), columns)
    usual, levels = _noise_of(batches, rate, band)
    for batch, level in zip(batches, levels, strict=True):
        for order, data, own in zip(batch.order, batch.data, level, strict=True):
            found[order] = (numbers[order], np.ascontiguousarray(data), (usual * own) ** 2)
    return [found[order] for order in sorted(found)]


def _noise_of(batches: tuple[Batch, ...], rate: float, band: Band) -> tuple[FloatArray, list[FloatArray]]:
    """Return the usual noise (sensor,), and that of each recording over it, (recording, sensor) of each batch."""
    levels = NoiseLevels.of(batches, rate, band)
    if levels.are_alike:
        return noise_of_recordings(batches, rate, band), [np.ones((len(b.names), b.data.shape[2])) for b in batches]
    return np.exp(levels.usual), [levels.of_recordings(batch) for batch in batches]


def track_of(dataset: Dataset, measured: Measured, fit: ModalFit, sizes: ErrorSizes | None = None) -> Track | None:
    """Return all motions as a fit's claim expects them, with the most probable discrepancy; see `expectation_of`."""
    expected = expectation_of(measured, fit, 1 / dataset.sampling_rate, sizes)
    if expected is None:
        return None
    motions = motions_with_noise(dataset, measured)
    modes = tuple(expected.modes[number] for number, _, _ in motions)

    def follow(item: tuple[int, FloatArray, FloatArray]) -> Followed:
        number, data, noise = item
        return Followed(data, noise, amplitudes_of(expected.modes[number].space, data, noise))

    return tracked(replace(expected, modes=modes), parallel_map(follow, motions))
