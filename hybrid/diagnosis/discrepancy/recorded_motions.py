"""Recordings as a filter follows them: each motion with its noise, beside the modes that a claim expects of it."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from hybrid.diagnosis.discrepancy.expected_modes import Claimed, ExpectedModes, expectation_of
from hybrid.diagnosis.discrepancy.tracking import Followed, Track, amplitudes_of, tracked
from hybrid.diagnosis.modal.claim import Measured
from hybrid.diagnosis.modal.errors import ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.nominal.lowpass import noise_is_lowpassed
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.batches import batches_of, columns_of, measured_columns
from hybrid.diagnosis.recorded.noise import noise_of_recordings, structure_band
from hybrid.diagnosis.recorded.noise_levels import NoiseLevels


def motions_with_noise(dataset: Dataset, measured: Measured) -> list[tuple[int, FloatArray, FloatArray]]:
    """Return the number of its training recording, the measured channels (time, sensor), and the variance of their
    noise (sensor,), of each motion.
    """
    columns = measured_columns(dataset)
    numbers = [number for number, recording in enumerate(dataset.select("train")) for _ in recording.data]
    found: dict[int, tuple[int, FloatArray, FloatArray]] = {}
    usual, levels = noise_in(dataset, measured)
    for batch in columns_of(batches_of(dataset, "train"), columns):
        each = np.ones((len(batch.names), len(columns))) if levels.are_alike else levels.of_recordings(batch)
        for order, data, own in zip(batch.order, batch.data, each, strict=True):
            found[order] = (numbers[order], np.ascontiguousarray(data), (usual * own) ** 2)
    return [found[order] for order in sorted(found)]


def noise_in(dataset: Dataset, measured: Measured) -> tuple[FloatArray, NoiseLevels]:
    """Return the usual noise (sensor,) of the recordings for training, and how it differs between them."""
    rate = dataset.sampling_rate
    band = structure_band(measured.nominal, rate, dataset.lowpass, white=not noise_is_lowpassed(dataset))
    batches = columns_of(batches_of(dataset, "train"), measured_columns(dataset))
    levels = NoiseLevels.of(batches, rate, band)
    return noise_of_recordings(batches, rate, band) if levels.are_alike else np.exp(levels.usual), levels


def track_of(dataset: Dataset, measured: Measured, fit: ModalFit, sizes: ErrorSizes | None = None) -> Track | None:
    """Return all motions as a fit's claim expects them, with the most probable discrepancy; see `Claimed`."""
    motions = motions_with_noise(dataset, measured)
    claimed = Claimed(measured, fit, 1 / dataset.sampling_rate, tuple(number for number, _, _ in motions), sizes)
    expected = expectation_of(claimed)
    if expected is None:
        return None

    def follow(item: tuple[ExpectedModes, tuple[int, FloatArray, FloatArray]]) -> Followed:
        modes, (_, data, noise) = item
        return Followed(data, noise, amplitudes_of(modes.space, data, noise))

    return tracked(claimed, expected, parallel_map(follow, list(zip(expected.modes, motions, strict=True))))
