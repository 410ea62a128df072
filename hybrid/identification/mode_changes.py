"""What changed from one recording to another: frequencies and damping ratios of the modes that both show, with chance.

Under no change the differences of n frequencies over their standard deviations have a sum of squares like n F, with n
and as many degrees of freedom as the deviations were estimated from.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse.csgraph import connected_components
from scipy.stats import f

from fe_models.arrays import BoolArray, FloatArray, IntArray
from fe_models.modes import mac
from hybrid.identification.config import AMBIENT, CHANGES, PAIRING
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.pairing import is_telling


@dataclass(frozen=True)
class ModeChange:
    """One mode of two recordings, by its ``numbers`` in each (from 0); its relative ``change`` of frequency and the
    change of its damping ratio, each with its standard deviation; ``mac`` of the two shapes.
    """

    numbers: tuple[int, int]
    change: float
    error: float
    ratio_change: float
    ratio_error: float
    mac: float

    @property
    def sigma(self) -> float:
        """The change of frequency in its standard deviations."""
        return self.change / self.error


@dataclass(frozen=True)
class RecordingChange:
    """Two ``recordings``, by number, and their ``modes``; ``chance``: of frequencies that differ as much in one state
    of the structure, None where no mode is seen in both and nothing can be told.
    """

    recordings: tuple[int, int]
    modes: tuple[ModeChange, ...]
    chance: float | None

    @property
    def is_plain(self) -> bool:
        """Whether the structure has changed from one recording to the other, beyond chance."""
        return self.chance is not None and self.chance < CHANGES.false_alarms

    @property
    def is_none(self) -> bool:
        """Whether both are of one state of the structure, as far as chance lets tell."""
        return self.chance is not None and not self.is_plain


def changes_among(
    identified: Sequence[IdentifiedModes], shapes: Sequence[FloatArray], chosen: Sequence[Sequence[int]] = ()
) -> tuple[RecordingChange, ...]:
    """Return what changed between each two recordings; ``shapes`` (sensor, mode) of their modes, comparable ones.

    ``chosen``: which mode of each recording is which of a model, -1 where none is; two that are one of its modes are
    compared however far apart they are. Of many recordings, from the first one of each state to each.
    """

    def between(i: int, j: int) -> RecordingChange:
        own = (chosen[i], chosen[j]) if chosen else ((), ())
        return _change((i, j), identified[i], identified[j], mac(shapes[i], shapes[j]), own)

    count = len(identified)
    if count <= CHANGES.max_recordings:
        return tuple(between(i, j) for i in range(count) for j in range(i + 1, count))
    found, firsts = list[RecordingChange](), list[int]()
    for j in range(count):
        own = [between(i, j) for i in firsts]
        found += own
        if not any(change.is_none for change in own):
            firsts.append(j)
    return tuple(sorted(found, key=lambda change: change.recordings))


def states_among(changes: Sequence[RecordingChange], recordings: int) -> list[list[int]]:
    """Return the numbers of recordings between which nothing changed, state by state, the largest first."""
    same = np.eye(recordings, dtype=bool)
    for change in changes:
        same[change.recordings] = change.is_none
    count, group = connected_components(same, directed=False)
    found = [np.flatnonzero(group == number).tolist() for number in range(count)]
    return sorted(found, key=lambda own: (-len(own), own))


def _change(
    numbers: tuple[int, int],
    before: IdentifiedModes,
    after: IdentifiedModes,
    criterion: FloatArray,
    chosen: tuple[Sequence[int], Sequence[int]],
) -> RecordingChange:
    """Return what changed in the modes that two recordings have in common, ``chosen`` as one of a model or alike."""
    alike = alike_by_shape(before.frequencies, after.frequencies, criterion, len(before.shapes))
    first, last = _of_model(chosen[0], len(before.roots))[:, None], _of_model(chosen[1], len(after.roots))
    alike = np.where((first >= 0) & (last >= 0), first == last, alike)
    pairs = sorted(common_modes(before.frequencies, after.frequencies, criterion, alike))
    modes = tuple(_mode_change(i, j, before, after, float(criterion[i, j])) for i, j in pairs)
    if not modes:
        return RecordingChange(numbers, (), None)
    mean = float(np.mean([mode.sigma**2 for mode in modes]))
    return RecordingChange(numbers, modes, float(f.sf(mean, len(modes), AMBIENT.segments - 1)))


def _of_model(chosen: Sequence[int], count: int) -> IntArray:
    """Return which of a model's modes each of ``count`` modes is, -1 where it is none, (mode,)."""
    found = np.full(count, -1)
    for mode, own in enumerate(chosen):
        if own >= 0:
            found[own] = mode
    return found


def _mode_change(i: int, j: int, before: IdentifiedModes, after: IdentifiedModes, criterion: float) -> ModeChange:
    """Return what changed in mode ``i`` of one recording, ``j`` of the other."""
    error = np.hypot(
        before.frequency_errors[i] / before.frequencies[i], after.frequency_errors[j] / after.frequencies[j]
    )
    return ModeChange(
        (i, j),
        float(after.frequencies[j] / before.frequencies[i] - 1),
        float(max(error, CHANGES.least_error)),
        float(after.ratios[j] - before.ratios[i]),
        float(np.hypot(before.ratio_errors[i], after.ratio_errors[j])),
        criterion,
    )


def common_modes(
    before: FloatArray, after: FloatArray, criterion: FloatArray, alike: BoolArray | None = None
) -> list[tuple[int, int]]:
    """Return which modes two recordings have in common, by shape and frequency together (see `pairing`).

    ``before`` (mode,) and ``after`` (other,): frequencies, Hz; ``criterion`` (mode, other), MAC. Of the modes that are
    left those that are ``alike`` (mode, other) are one mode each, however far its frequency moved.
    """
    if not criterion.size:
        return []
    apart = np.abs(np.log(after / before[:, None]))
    cost = (1 - criterion) / PAIRING.mac_scale + apart / PAIRING.frequency_scale
    pairs = _cheapest(cost, (criterion >= CHANGES.min_mac) & (apart <= CHANGES.max_change))
    if alike is not None:
        left = alike.copy()
        for i, j in pairs:
            left[i, :] = left[:, j] = False
        pairs += _cheapest(cost, left)
    return pairs


def alike_by_shape(before: FloatArray, after: FloatArray, criterion: FloatArray, sensors: int) -> BoolArray:
    """Return which modes (mode, other) are alike by their shapes at so many ``sensors`` alone, as `common_modes` takes
    them; a frequency may have moved far.
    """
    telling = (criterion >= CHANGES.alone_mac) & is_telling(criterion, sensors)
    return np.asarray(telling & (np.abs(np.log(after / before[:, None])) <= CHANGES.alone_change))


def _cheapest(cost: FloatArray, possible: BoolArray) -> list[tuple[int, int]]:
    """Return as many of the ``possible`` pairs as there can be, those that cost the least together."""
    rows, columns = linear_sum_assignment(np.where(possible, cost, PAIRING.max_cost + cost.max()))
    return [(int(i), int(j)) for i, j in zip(rows, columns, strict=True) if possible[i, j]]
