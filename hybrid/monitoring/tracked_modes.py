"""Which mode of one recording is which of another, through a whole history."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.modes import mac
from hybrid.identification.mode_changes import alike_by_shape, common_modes
from hybrid.monitoring.observation import Observation, SeenMode


@dataclass(frozen=True)
class TrackedModes:
    """Modes that run through a history: ``numbers`` (recording, mode), which mode of a recording each is, -1 where it
    is not seen; usual ``frequencies`` (mode,), Hz, and ``shapes`` (sensor, mode).
    """

    numbers: "np.ndarray[tuple[int, int], np.dtype[np.int64]]"
    frequencies: FloatArray
    shapes: FloatArray

    def of(self, observation: Observation) -> list[SeenMode | None]:
        """Return each tracked mode as another recording shows it, None where it does not.

        A mode whose frequency moved far is known by its shape, where the sensors tell that from others.
        """
        found: list[SeenMode | None] = [None] * len(self.frequencies)
        if observation.modes and len(self.frequencies):
            criterion = np.atleast_2d(mac(self.shapes, observation.shapes))
            alike = alike_by_shape(self.frequencies, observation.frequencies, criterion, len(self.shapes))
            for mode, own in common_modes(self.frequencies, observation.frequencies, criterion, alike):
                found[mode] = observation.modes[own]
        return found


def tracked(history: Sequence[Observation], min_seen: float, most: int) -> TrackedModes:
    """Return the modes that a share of ``min_seen`` of the ``history`` shows, at most so many, by frequency.

    Each recording is held against the mean frequencies, and the first shapes, of the modes so far; what it shows
    besides begins a mode of its own. Of too many the strongest stay.
    """
    rows = list[dict[int, int]]()
    frequencies, shapes = list[list[float]](), list[tuple[float, ...]]()
    for observation in history:
        row = dict[int, int]()
        if frequencies and observation.modes:
            usual = np.array([np.mean(own) for own in frequencies])
            criterion = np.atleast_2d(mac(np.array(shapes).T, observation.shapes))
            row = dict(common_modes(usual, observation.frequencies, criterion))
        for own in sorted(set(range(len(observation.modes))) - set(row.values())):
            row[len(frequencies)] = own
            frequencies.append([])
            shapes.append(observation.modes[own].shape)
        for mode, own in row.items():
            frequencies[mode].append(observation.modes[own].frequency)
        rows.append(row)
    numbers = np.full((len(history), len(frequencies)), -1)
    energy = np.zeros(len(frequencies))
    for k, row in enumerate(rows):
        for mode, own in row.items():
            numbers[k, mode] = own
            energy[mode] += history[k].modes[own].energy
    stays = np.flatnonzero((numbers >= 0).sum(axis=0) >= max(1.0, min_seen * len(history)))
    stays = stays[np.argsort(-energy[stays])[:most]]
    stays = np.array(sorted(stays, key=lambda mode: float(np.mean(frequencies[mode]))), dtype=int)
    usual = np.array([np.mean(frequencies[mode]) for mode in stays])
    kept = np.array([shapes[mode] for mode in stays], dtype=float).T
    return TrackedModes(numbers[:, stays], usual, kept)
