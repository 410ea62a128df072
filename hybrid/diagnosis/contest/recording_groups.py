"""Recordings in two groups, told apart by how much of a cause each of them asks for."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fe_models.arrays import TINY, BoolArray, FloatArray, IntArray
from fe_models.causes.candidate import Candidate, HarmonicCandidate, LawCandidate, SupportCandidate
from hybrid.diagnosis.contest.config import GROUPS
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.recorded.batches import Batch, as_made, count_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.screening.screening import amounts_by_recording

Groups = tuple[tuple[Batch, ...], tuple[Batch, ...]]


@dataclass(frozen=True)
class Asked:
    """How much of a ``candidate`` each recording asks for: ``amounts`` (recording,), nan where it hardly feels it, and
    how much it feels of a unit, ``sizes`` (recording,); ``made`` (recording,): their positions as they were made.
    """

    candidate: Candidate
    amounts: FloatArray
    sizes: FloatArray
    made: IntArray

    @property
    def gain(self) -> float:
        """The fall in the sum of squares that these amounts promise."""
        return float(np.nansum(self.amounts**2 * self.sizes))

    @property
    def high(self) -> BoolArray:
        """Which recordings (recording,) are of one of two groups: those after a change, or those that ask for more."""
        if self.is_change:
            place = np.argsort(self.made)
            return np.asarray(place >= place[self._change[0]])
        return np.nan_to_num(self.amounts, nan=-np.inf) >= self._split()[0]

    @property
    def is_change(self) -> bool:
        """Whether from one recording on they ask for another amount, as chance rarely has it."""
        return self._change[1] < GROUPS.max_chance

    @cached_property
    def _change(self) -> tuple[int, float]:
        """Return the first recording after the clearest change, and how often one is as clear in another order."""
        felt = self.made[np.isfinite(self.amounts[self.made])]
        orders = np.random.default_rng(GROUPS.seed).permuted(np.tile(felt, (GROUPS.orders, 1)), axis=1)
        gains = _gains_of_changes(*(values[np.vstack([felt, orders])] for values in (self.amounts, self.sizes)))
        found = gains.max(axis=1)
        return int(felt[np.argmax(gains[0]) + 1]), float(np.mean(found >= (1 - GROUPS.rounding) * found[0]))

    @property
    def within(self) -> float:
        """The share of the variance that is left within these groups."""
        return self._split()[1]

    def _split(self) -> tuple[float, float]:
        """Return the least amount of the upper group, and the share of the variance within the groups."""
        ranked = np.sort(self.amounts[np.isfinite(self.amounts)])
        spread = [np.var(ranked[:k]) * k + np.var(ranked[k:]) * (len(ranked) - k) for k in range(1, len(ranked))]
        first = int(np.argmin(spread)) + 1
        return float(ranked[first]), float(min(spread) / (np.var(ranked) * len(ranked) + TINY))


def _gains_of_changes(amounts: FloatArray, sizes: FloatArray) -> FloatArray:
    """Return the sum of squares (order, change) that two amounts tell, one before and one after each recording."""
    weight, along = (np.cumsum(values, axis=1) for values in (sizes, sizes * amounts))
    before, after = weight[:, :-1], weight[:, -1:] - weight[:, :-1]
    return np.asarray(along[:, :-1] ** 2 / before + (along[:, -1:] - along[:, :-1]) ** 2 / after)


def asked_for(short: Fit, candidates: tuple[Candidate, ...], noise_model: NoiseModel) -> tuple[Asked, ...]:
    """Return the candidates that promise most beside a fit, if each recording had its own amount, best first.

    Of fewer than three recordings, or where fewer feel a candidate, nothing is told.
    """
    if count_of(short.batches) < GROUPS.min_recordings:
        return ()
    taken = {candidate.key for candidate in short.hypothesis.candidates}
    usable = [c for c in candidates if c.names and not isinstance(c, HarmonicCandidate) and c.key not in taken]
    if not short.hypothesis.is_linear:  # whose initial states are searched, too: one size of them for all recordings
        usable = [candidate for candidate in usable if not isinstance(candidate, SupportCandidate)]
    middle = [replace(c, starts=(c.first_starts[len(c.first_starts) // 2],)) for c in usable]
    ranked: list[Asked] = []
    for candidate, (amounts, sizes) in zip(usable, amounts_by_recording(short, middle, noise_model), strict=True):
        felt = (sizes > 0) & (sizes >= GROUPS.min_felt_share * np.max(sizes))
        if np.isfinite(amounts).all() and felt.sum() >= GROUPS.min_recordings:
            ranked.append(Asked(candidate, np.where(felt, amounts, np.nan), sizes, as_made(short.batches)))
    ranked.sort(key=lambda item: -item.gain)
    chosen: list[Asked] = []
    for item in ranked:
        laws = sum(isinstance(other.candidate, LawCandidate) for other in chosen)
        if len(chosen) < GROUPS.tried and not (isinstance(item.candidate, LawCandidate) and laws >= GROUPS.tried_laws):
            chosen.append(item)
    return tuple(chosen)


def clear_share(recordings: int) -> float:
    """Return the share of the variance of normal draws that is less than this within the better two of all groups of
    them in less than 1 of 100 cases: 0.0016 of four recordings, 0.05 of nine. Three would have to agree to 1e-5, which
    noise forbids: for these, and for fewer, it is 0.
    """
    return float(GROUPS.min_clear_share ** (1 + 6 / (recordings - 2))) if recordings > GROUPS.min_recordings else 0.0


def clear_groups(asked: tuple[Asked, ...], batches: tuple[Batch, ...]) -> Groups | None:
    """Return the recordings in the two groups that the most promising candidate tells clearly apart, if one does."""
    clear = clear_share(count_of(batches))
    high = next((item.high for item in asked if item.within < clear or item.is_change), None)
    if high is None:
        return None
    parts = each_with(batches, high)
    lower, upper = (
        tuple(batch.take(np.flatnonzero(own == side).tolist()) for batch, own in parts if (own == side).any())
        for side in (False, True)
    )
    return lower, upper


def each_of_two(batches: tuple[Batch, ...]) -> Groups | None:
    """Return two recordings as a group each; None of more or fewer, or where they are the halves of one."""
    names = [name for batch in batches for name in batch.names]
    begins = {begin for batch in batches for begin in batch.skipped or (0,)}
    if len(names) != 2 or (len(set(names)) == 1 and len(begins) == 2):
        return None
    first, second = (batch.take([number]) for batch in batches for number in range(len(batch.names)))
    return (first,), (second,)


def each_with(batches: tuple[Batch, ...], chosen: BoolArray) -> list[tuple[Batch, BoolArray]]:
    """Return each batch with the part of ``chosen`` (recording,) that tells of its recordings."""
    ends = np.cumsum([len(batch.names) for batch in batches])
    return list(zip(batches, np.split(chosen, ends[:-1]), strict=True))
