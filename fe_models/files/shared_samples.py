"""Recordings that share a stretch of samples: a forecast of what was trained on says nothing of what is unseen."""

from collections.abc import Iterator, Sequence

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from fe_models.files.recording_checks import MIN_SAMPLES
from fe_models.recordings import Recording


def shared_stretches(recordings: Sequence[Recording]) -> list[str]:
    """Return a fault for each test recording that shares `MIN_SAMPLES` samples in a row with a training recording."""
    some = [each for each in recordings if each.data.size]  # none where no sensor could be read
    tests, trains = ([each for each in some if each.role == role] for role in ("test", "train"))
    known = {each.name: _Stretches(each.data) for each in some}
    faults = []
    for test in tests:
        for train in trains:
            if test.data.shape[2] == train.data.shape[2] and (
                known[train.name].holds_any(test.data) or known[test.name].holds_any(train.data)
            ):
                whole = test.data.shape == train.data.shape and np.array_equal(test.data, train.data)
                what = "the same samples as" if whole else "a stretch of the samples of"
                faults.append(
                    f"recording {test.name!r} is for testing, but holds {what} {train.name!r}, which is trained on"
                )
    return faults


class _Stretches:
    """Finds samples in the motions of a recording (realisation, time, sensor)."""

    def __init__(self, data: FloatArray) -> None:
        self.motions, self.samples = data.shape[:2]
        self.rows = data.reshape(-1, data.shape[2])  # of one motion after the other
        self.order = np.argsort(self.rows[:, 0], kind="stable")
        self.sorted = self.rows[self.order, 0]

    def holds_any(self, data: FloatArray) -> bool:
        """Return whether the first stretch that moves, of any of the motions in ``data``, is among these samples."""
        return any(len(self._places(probe)) > 0 for probe in _first_moving(data))

    def _places(self, probe: FloatArray) -> IntArray:
        """Return where ``probe`` (sample, sensor) begins."""
        first, last = (np.searchsorted(self.sorted, probe[0, 0], side) for side in ("left", "right"))
        places = self.order[first:last]
        places = places[places % self.samples <= self.samples - len(probe)]
        for later in range(len(probe)):  # few are left after the first
            places = places[(self.rows[places + later] == probe[later]).all(axis=1)]
        return places


def _first_moving(data: FloatArray) -> Iterator[FloatArray]:
    """Yield the first `MIN_SAMPLES` samples of each motion in which every channel changes; silence is shared by all."""
    for motion in data:
        for start in range(0, len(motion) - MIN_SAMPLES + 1, MIN_SAMPLES):
            probe = motion[start : start + MIN_SAMPLES]
            if np.ptp(probe, axis=0).all():
                yield probe
                break
