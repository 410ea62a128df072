"""Recordings as arrays for fitting: batches of equal length, cut into segments with initial states of their own."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.recordings import Dataset


@dataclass(frozen=True)
class Batch:
    """``data`` (recording, time, sensor) of recordings with the same length and ``names`` (recording,).

    ``off``: numbers of the hypothesis' candidates that do not act in these recordings. ``pieces``: segments that each
    recording was cut into, which follow one another along the first axis. ``share``: of all frequencies up to half the
    sampling rate, those that a low-pass has left. ``whole``: what was recorded, where ``data`` are that less
    something known (see `geometry_response`); None where they are the same.
    """

    data: FloatArray
    names: tuple[str, ...]
    off: tuple[int, ...] = ()
    pieces: int = 1
    share: float = 1.0
    whole: FloatArray | None = None

    @property
    def recorded(self) -> FloatArray:
        """The recordings as they are, (recording, time, sensor)."""
        return self.data if self.whole is None else self.whole

    def less(self, known: FloatArray) -> "Batch":
        """Return the batch of what was recorded less what is ``known`` of it (recording, time, sensor)."""
        return replace(self, data=self.recorded - known, whole=self.recorded)

    @property
    def samples(self) -> int:
        """Samples of each recording or segment."""
        return self.data.shape[1]

    @property
    def begins(self) -> FloatArray:
        """When each recording or segment begins in its recording, in samples."""
        return np.tile(np.arange(self.pieces) * float(self.samples), len(self.data) // self.pieces)

    def take(self, recordings: list[int]) -> "Batch":
        """Return the batch with some of its recordings."""
        rows = [i * self.pieces + piece for i in recordings for piece in range(self.pieces)]
        whole = None if self.whole is None else self.whole[rows]
        return replace(self, data=self.data[rows], names=tuple(self.names[i] for i in recordings), whole=whole)

    def cut(self, length: int) -> "Batch":
        """Return its recordings cut into segments of ``length`` samples; what is left at the end is dropped."""
        recordings, samples, sensors = self.data.shape
        pieces = max(samples // length, 1)
        length = min(length, samples)
        data = self.data[:, : pieces * length].reshape(recordings * pieces, length, sensors)
        return replace(self, data=data, pieces=pieces, whole=None)


def batches_of(dataset: Dataset, role: Literal["train", "test"]) -> tuple[Batch, ...]:
    """Return the recordings of one role, those of equal length together; several in one file share its name."""
    by_length: dict[int, list[tuple[str, FloatArray]]] = {}
    for recording in dataset.select(role):
        for data in recording.data:
            by_length.setdefault(len(data), []).append((recording.name, data))
    share = min(dataset.lowpass / (dataset.sampling_rate / 2), 1.0) if dataset.lowpass else 1.0
    return tuple(
        Batch(np.stack([data for _, data in items]), tuple(name for name, _ in items), share=share)
        for items in by_length.values()
    )


def measured_columns(dataset: Dataset) -> tuple[int, ...]:
    """Return the columns of the sensors that are fitted."""
    return tuple(column for column, sensor in enumerate(dataset.sensors) if sensor.role == "measured")


def columns_of(batches: tuple[Batch, ...], columns: tuple[int, ...]) -> tuple[Batch, ...]:
    """Return the batches with some of their channels."""
    return tuple(replace(batch, data=batch.data[..., list(columns)]) for batch in batches)
