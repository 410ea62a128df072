"""Recordings as arrays for fitting: batches of equal length, cut into segments with initial states of their own."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fe_models.arrays import BoolArray, FloatArray, IntArray
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.nominal.loads import Loads, loads_of
from hybrid.diagnosis.nominal.lowpass import noise_is_lowpassed
from hybrid.diagnosis.recorded.noise_model import NoiseModel


@dataclass(frozen=True)
class Batch:
    """``data`` (recording, time, sensor) of recordings with the same length and ``names`` (recording,).

    ``off``: numbers of the hypothesis' candidates that do not act in these recordings. ``pieces``: segments that each
    recording was cut into, which follow one another along the first axis. ``share``: of all frequencies up to half the
    sampling rate, those where a low-pass has left noise. ``loads``: what is known to act, None where nothing is.
    ``whole``: what was recorded, where ``data`` are that less something known (see `geometry_response`); None where
    they are the same. ``noise`` (recording, sensor): of each recording over the noise model's; None where all are
    alike. ``order`` (recording,): its place among all as they were made, which batches of unequal lengths are not in;
    empty: that in which they stand here. ``skipped`` (recording,): samples of each before the first one here; empty:
    none.
    """

    data: FloatArray
    names: tuple[str, ...]
    off: tuple[int, ...] = ()
    pieces: int = 1
    share: float = 1.0
    loads: Loads | None = None
    whole: FloatArray | None = None
    noise: FloatArray | None = None
    order: tuple[int, ...] = ()
    skipped: tuple[int, ...] = ()

    def sigma(self, noise_model: NoiseModel) -> FloatArray:
        """Return the standard deviation of the noise (recording or segment, 1, sensor); one row where all are alike."""
        if self.noise is None:
            return noise_model.sigma[None, None]
        return np.repeat(self.noise, self.pieces, axis=0)[:, None] * noise_model.sigma

    def weights(self, noise_model: NoiseModel) -> FloatArray:
        """Return one over `sigma` for each value (recording or segment, value); one row where all are alike."""
        return np.tile(1 / self.sigma(noise_model)[:, 0], self.samples)

    @property
    def recorded(self) -> FloatArray:
        """The recordings as they are, (recording, time, sensor)."""
        return self.data if self.whole is None else self.whole

    @property
    def restored(self) -> "Batch":
        """The batch of the recordings as they are."""
        return replace(self, data=self.recorded, whole=None)

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
        within = np.tile(np.arange(self.pieces) * float(self.samples), len(self.data) // self.pieces)
        return within + np.repeat(self.skipped, self.pieces) if self.skipped else within

    def take(self, recordings: list[int]) -> "Batch":
        """Return the batch with some of its recordings, each with all its segments."""
        rows = np.concatenate([number * self.pieces + np.arange(self.pieces) for number in recordings])
        names = tuple(self.names[number] for number in recordings)
        whole = None if self.whole is None else self.whole[rows]
        noise = None if self.noise is None else self.noise[recordings]
        loads = self.loads and self.loads.take(rows)
        order, skipped = (
            tuple(known[number] for number in recordings) if known else () for known in (self.order, self.skipped)
        )
        own = replace(self, data=self.data[rows], names=names, loads=loads, whole=whole, noise=noise)
        return replace(own, order=order, skipped=skipped)

    def first(self, samples: int) -> "Batch":
        """Return the first ``samples`` of its recordings (uncut)."""
        whole = None if self.whole is None else self.whole[:, :samples]
        return replace(self, data=self.data[:, :samples], loads=self.loads and self.loads.first(samples), whole=whole)

    def cut(self, length: int) -> "Batch":
        """Return its recordings cut into segments of ``length`` samples; what is left at the end is dropped."""
        recordings, samples, sensors = self.data.shape
        pieces = max(samples // length, 1)
        length = min(length, samples)
        data = self.data[:, : pieces * length].reshape(recordings * pieces, length, sensors)
        loads = self.loads and self.loads.cut(pieces, length)
        return replace(self, data=data, pieces=pieces, loads=loads, whole=None)


def batches_of(
    dataset: Dataset, role: Literal["train", "test"], recordings: Sequence[Recording] | None = None
) -> tuple[Batch, ...]:
    """Return the recordings of one role, or those ``recordings`` of a dataset: those of equal length together, loaded
    ones apart; several in one file share its name.
    """
    alike: dict[tuple[int, bool], list[tuple[int, Recording, FloatArray]]] = {}
    motions = [(r, data) for r in (dataset.select(role) if recordings is None else recordings) for data in r.data]
    for number, (recording, data) in enumerate(motions):
        alike.setdefault((len(data), recording.is_driven), []).append((number, recording, data))
    rate, lowpass = dataset.sampling_rate, dataset.lowpass
    share = lowpass / (rate / 2) if lowpass and noise_is_lowpassed(dataset) else 1.0
    return tuple(
        Batch(
            np.stack([data for _, _, data in items]),
            tuple(recording.name for _, recording, _ in items),
            share=share,
            loads=loads_of([recording for _, recording, _ in items], samples, dataset),
            order=tuple(number for number, _, _ in items),
            skipped=tuple(recording.skipped for _, recording, _ in items),
        )
        for (samples, _), items in alike.items()
    )


def as_made(batches: tuple[Batch, ...]) -> IntArray:
    """Return the positions (recording,) of the recordings of all batches, one behind the other, as they were made."""
    order = [number for batch in batches for number in batch.order]
    return np.argsort(order) if order else np.arange(count_of(batches))


def acting_as_made(batches: tuple[Batch, ...], number: int) -> BoolArray:
    """Return in which recordings (recording,), as they were made, candidate ``number`` of a hypothesis acts."""
    acts = np.concatenate([np.full(len(batch.names), number not in batch.off) for batch in batches])
    return acts[as_made(batches)]


def count_of(batches: tuple[Batch, ...]) -> int:
    """Return the number of recordings, however many segments each was cut into."""
    return sum(len(batch.names) for batch in batches)


def measured_columns(dataset: Dataset) -> tuple[int, ...]:
    """Return the columns of the sensors that are fitted."""
    return tuple(column for column, sensor in enumerate(dataset.sensors) if sensor.role == "measured")


def columns_of(batches: tuple[Batch, ...], columns: tuple[int, ...]) -> tuple[Batch, ...]:
    """Return the batches with some of their channels."""
    own = list(columns)

    def some(values: FloatArray | None) -> FloatArray | None:
        return None if values is None else values[..., own]

    return tuple(
        replace(batch, data=batch.data[..., own], whole=some(batch.whole), noise=some(batch.noise)) for batch in batches
    )
