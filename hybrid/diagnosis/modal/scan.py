"""Which causes are worth a fit: each at several sizes, in several groups of recordings, by the modes that it makes.

From each size one step of least squares is taken in closed form, nominal values and errors marginalised as in the fit
that it is added to: what it would gain ranks the causes. Modes are paired anew, as a large change moves them past one
another.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from fe_models.arrays import BoolArray, FloatArray
from fe_models.causes.candidate import (
    Candidate,
    MatrixCandidate,
    ModeCandidate,
    SensorCandidate,
)
from hybrid.diagnosis.modal.config import CLAIM_SCAN
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import free_values
from hybrid.diagnosis.modal.pairing import paired
from hybrid.diagnosis.modal.predicted_modes import PredictedModes, predicted_modes
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.response.hypothesis import Hypothesis

Recordings = tuple[int, ...]


@dataclass(frozen=True)
class ClaimTrial:
    """A ``candidate`` of a ``size`` in the recordings where it ``acts``, and what its log evidence may ``gain``."""

    candidate: Candidate
    size: float
    acts: Recordings
    gain: float


def shows_in_modes(candidate: Candidate) -> bool:
    """Return whether modes tell a cause, by one size: what changes matrices, a mode, or a sensor's gain or delay."""
    drifts = isinstance(candidate, SensorCandidate) and candidate.quantity == "drift"
    return isinstance(candidate, MatrixCandidate | ModeCandidate | SensorCandidate) and not drifts


def scan_claims(
    measured: ModalData, base: ModalFit, candidates: Sequence[Candidate], groups: Sequence[Recordings]
) -> list[ClaimTrial]:
    """Return the trials of all ``candidates`` in all ``groups`` of recordings, most promising first."""
    taken = {candidate.key for candidate in base.claim.hypothesis.candidates}
    own = [candidate for candidate in candidates if shows_in_modes(candidate) and candidate.key not in taken]
    found = parallel_map(_Scan(measured, base, tuple(groups)).trials, own)
    return sorted((trial for trials in found for trial in trials), key=lambda trial: -trial.gain)


def worth_a_fit(ranked: Sequence[ClaimTrial], most: int) -> Sequence[ClaimTrial]:
    """Return the first of ``ranked`` trials, at ``most`` so many: as many as may be the best of all when fitted."""
    least = CLAIM_SCAN.min_promise * max((trial.gain for trial in ranked), default=0.0)
    return ranked[: min(sum(trial.gain >= least for trial in ranked), most)]


def sizes_of(candidate: Candidate) -> FloatArray:
    """Return the sizes (size,) at which a cause is tried, in bounds."""
    sizes = np.unique(
        np.concatenate([candidate.neutral[0] + np.array(CLAIM_SCAN.sizes) * candidate.width[0], candidate.far])
    )
    most = candidate.upper[0] if candidate.upper else np.inf
    return np.asarray(sizes[(sizes > candidate.lower[0]) & (sizes < most)])


@dataclass(frozen=True, eq=False)
class _Scan:
    """Trials beside a fit, the ``base``, to what was ``measured``, in ``groups`` of recordings."""

    measured: ModalData
    base: ModalFit
    groups: tuple[Recordings, ...]

    def trials(self, candidate: Candidate) -> list[ClaimTrial]:
        """Return a candidate in each group, of the size that promises most; none where the structure does not stand."""
        with_it = self.base.claim.hypothesis.adding(candidate)
        sizes = sizes_of(candidate)
        sizes = sizes[with_it.weighs(_with_each(self.base.theta, sizes))]
        found = self._left(with_it, sizes) if len(sizes) else None
        if found is None:
            return []
        left, stands = found
        if not stands.any():
            return []
        return self._best_trials(candidate, sizes[stands], left[stands] - self.base.residual)

    @cached_property
    def _shown(self) -> list[int]:
        """The recordings of all groups."""
        return sorted({recording for group in self.groups for recording in group})

    @cached_property
    def _deviation(self) -> FloatArray:
        """How far nominal values (nuisance,) are from their centre."""
        return np.asarray(self.base.theta[: self.base.nuisances] + self.measured.offset)

    @cached_property
    def _basis(self) -> FloatArray:
        """An orthonormal basis (row, parameter) of what the causes of the base move, in units of all errors."""
        if not self.base.claim.hypothesis.candidates:
            return np.zeros((len(self.base.residual), 0))
        fitted = solve_triangular(self.base.lower, self.base.slopes[:, self.base.nuisances :], lower=True)
        return np.asarray(np.linalg.qr(fitted)[0])

    @cached_property
    def _masks(self) -> BoolArray:
        """Which rows are of each group, (group, row)."""
        return np.array([np.isin(self.base.rows.recording, group) for group in self.groups])

    def _left(self, with_it: Hypothesis, sizes: FloatArray) -> tuple[FloatArray, BoolArray] | None:
        """Return what is left of all rows, (size, row), where a candidate of these ``sizes`` acts in the recordings of
        all groups, nominal values at their centre; and at which sizes the structure stands. None where it has no modes.
        """
        base, claim = self.base, self.base.claim
        free = free_values(base.pairs.reference, len(self.measured.sensors))
        to_centre = base.rows.slopes @ self._deviation
        residuals, stands = np.zeros((len(sizes), *free.shape)), np.ones(len(sizes), dtype=bool)
        residuals[:, free] = base.residual - to_centre
        for idle in dict.fromkeys(claim.idle_in(recording) for recording in self._shown):
            hypothesis, kept = with_it.less(idle), claim.hypothesis.parameters_of(idle)
            modes = predicted_modes(hypothesis, _with_each(base.theta[kept], sizes), self.measured.outputs)
            if modes is None or not modes.roots.shape[1]:
                return None
            stands &= modes.stands
            for recording in self._shown:
                if claim.idle_in(recording) == idle:
                    residuals[:, base.pairs.recording == recording] = self._left_in(recording, modes)
        return residuals[:, free] + to_centre, stands

    def _left_in(self, recording: int, modes: PredictedModes) -> FloatArray:
        """Return what ``modes`` leave of the values (variant, pair, value) of a recording's pairs, paired anew."""
        pairs, seen = self.base.pairs, self.measured.recordings[recording]
        here = np.flatnonzero(pairs.recording == recording)
        measured, stands = pairs.measured[here], modes.stands
        values = seen.values_over(pairs.references_in(recording, seen.count)).values[measured]
        anew = np.full((len(stands), seen.count), -1)
        anew[stands] = paired(seen, modes.log_omega[stands], modes.shapes[stands], self.measured.orders)
        anew = anew[:, measured]
        known = np.minimum(pairs.mode[here], modes.roots.shape[1] - 1)
        return values - modes.values_over(np.where(anew >= 0, anew, known), pairs.reference[here])

    def _best_trials(self, candidate: Candidate, sizes: FloatArray, changes: FloatArray) -> list[ClaimTrial]:
        """Return the best size of a candidate in each group; ``changes`` (size, row) of what is left by its action."""
        base, basis = self.base, self._basis
        width, neutral = candidate.width[0], candidate.neutral[0]
        masked = changes * self._masks[:, None]  # (group, size, row)
        white = solve_triangular(base.lower, masked.reshape(-1, masked.shape[-1]).T, lower=True)
        white = white.T.reshape(masked.shape)
        start = base.white - basis @ (basis.T @ base.white)
        white = white - (white @ basis) @ basis.T
        left = start + white
        nothing = int(np.searchsorted(sizes, neutral))  # where a size that does nothing stands among them
        slope = -np.gradient(np.insert(white, nothing, 0.0, axis=1), np.insert(sizes, nothing, neutral), axis=1)
        slope = np.delete(slope, nothing, axis=1)
        precision = np.sum(slope**2, axis=-1) + 1 / width**2
        off = sizes - neutral
        step = (np.sum(slope * left, axis=-1) - off / width**2) / precision
        cost = np.sum((left - slope * step[..., None]) ** 2, axis=-1) + ((off + step) / width) ** 2
        gain = 0.5 * (float(start @ start) - cost) - 0.5 * np.log(precision * width**2)
        best = np.argmax(gain, axis=1)
        trials = []
        for number, group in enumerate(self.groups):
            size = sizes[best[number]] + np.clip(step[number, best[number]], -width, width)
            least, most = candidate.lower[0], candidate.upper[0] if candidate.upper else np.inf
            inside = size if least < size < most else sizes[best[number]]
            trials.append(ClaimTrial(candidate, float(inside), group, float(gain[number, best[number]])))
        return trials


def _with_each(theta: FloatArray, sizes: FloatArray) -> FloatArray:
    """Return theta (parameter,) with each of the sizes (size,) of one candidate more, (size, parameter)."""
    return np.column_stack([np.repeat(theta[None], len(sizes), axis=0), sizes])
