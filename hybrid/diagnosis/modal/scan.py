"""Which causes are worth a fit: each at several sizes, in several groups of recordings, by the modes that it makes.

From each size one step of least squares is taken in closed form, nominal values and errors marginalised as in the fit
that it is added to: what it would gain ranks the causes. Modes are paired anew, as a large change moves them past one
another.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from fe_models.arrays import BoolArray, FloatArray
from fe_models.causes.candidate import (
    Candidate,
    MatrixCandidate,
    ModeCandidate,
    SensorCandidate,
)
from hybrid.diagnosis.modal.config import SCAN
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import free_values
from hybrid.diagnosis.modal.pairing import paired
from hybrid.diagnosis.modal.predicted_modes import predicted_modes
from hybrid.diagnosis.parallel import parallel_map

Recordings = tuple[int, ...]


@dataclass(frozen=True)
class Trial:
    """A ``candidate`` of a ``size`` in the recordings where it ``acts``, and what its log evidence may ``gain``."""

    candidate: Candidate
    size: float
    acts: Recordings
    gain: float


def shows_in_modes(candidate: Candidate) -> bool:
    """Return whether modes tell a cause, and by one size: not force laws, drifts and harmonic forces."""
    drifts = isinstance(candidate, SensorCandidate) and candidate.quantity == "drift"
    return isinstance(candidate, MatrixCandidate | ModeCandidate | SensorCandidate) and not drifts


def scan(
    measured: ModalData,
    base: ModalFit,
    candidates: Sequence[Candidate],
    groups: Sequence[Recordings],
) -> list[Trial]:
    """Return the trials of all ``candidates`` in all ``groups`` of recordings, most promising first."""
    taken = {candidate.key for candidate in base.claim.hypothesis.candidates}
    own = [candidate for candidate in candidates if shows_in_modes(candidate) and candidate.key not in taken]
    first, hypothesis = base.nuisances, base.claim.hypothesis
    total = base.theta[:first] + measured.offset
    at_centre = base.residual  # where nominal values are at their centre
    fitted = solve_triangular(base.lower, base.slopes[:, first:], lower=True)
    basis = np.linalg.qr(fitted)[0] if len(hypothesis.candidates) else np.zeros((len(at_centre), 0))
    masks = np.array([np.isin(base.rows.recording, group) for group in groups])
    shown = sorted({recording for group in groups for recording in group})

    def tried(candidate: Candidate) -> list[Trial]:
        moved = _moved(measured, base, candidate, total, sizes_of(candidate), shown)
        if moved is None:
            return []
        sizes, residuals = moved
        return _ranked(base, candidate, sizes, residuals - at_centre, masks, groups, basis)

    found = [trial for trials in parallel_map(tried, own) for trial in trials]
    return sorted(found, key=lambda trial: -trial.gain)


def sizes_of(candidate: Candidate) -> FloatArray:
    """Return the sizes (size,) at which a cause is tried, in bounds."""
    sizes = np.unique(np.concatenate([candidate.neutral[0] + np.array(SCAN.sizes) * candidate.width[0], candidate.far]))
    most = candidate.upper[0] if candidate.upper else np.inf
    return np.asarray(sizes[(sizes > candidate.lower[0]) & (sizes < most)])


def _moved(
    measured: ModalData,
    base: ModalFit,
    candidate: Candidate,
    total: FloatArray,
    sizes: FloatArray,
    shown: Sequence[int],
) -> tuple[FloatArray, FloatArray] | None:
    """Return those of the ``sizes`` (size,) at which the structure stands, and what is left of all rows, (size, row),
    with each of them in the recordings that are ``shown``; nominal values at their centre.
    """
    claim = base.claim
    with_it = claim.hypothesis.adding(candidate)
    sizes = sizes[with_it.weighs(_with_each(base.theta, sizes))]
    if not len(sizes):
        return None
    pairs, free = base.pairs, free_values(base.pairs.reference, len(measured.sensors))
    residuals, stands = np.zeros((len(sizes), *free.shape)), np.ones(len(sizes), dtype=bool)
    residuals[:, free] = base.residual - base.rows.slopes @ total
    for idle in dict.fromkeys(claim.idle_in(recording) for recording in shown):
        hypothesis, kept = with_it.less(idle), claim.hypothesis.parameters_of(idle)
        modes = predicted_modes(hypothesis, _with_each(base.theta[kept], sizes), measured.outputs)
        if modes is None or not modes.roots.shape[1]:
            return None
        stands &= modes.stands
        for recording in shown:
            if claim.idle_in(recording) != idle:
                continue
            seen = measured.recordings[recording]
            here = np.flatnonzero(pairs.recording == recording)
            values = seen.over(pairs.references_in(recording, seen.count)).values[pairs.measured[here]]
            modes_of = np.full((len(sizes), seen.count), -1)
            modes_of[modes.stands] = paired(
                seen, modes.log_omega[modes.stands], modes.shapes[modes.stands], measured.orders
            )
            modes_of = modes_of[:, pairs.measured[here]]
            known = np.minimum(pairs.mode[here], modes.roots.shape[1] - 1)
            modes_of = np.where(modes_of >= 0, modes_of, known)
            residuals[:, here] = values - modes.over(modes_of, pairs.reference[here])
    left = residuals[:, free] + base.rows.slopes @ total
    return (sizes[stands], left[stands]) if stands.any() else None


def _with_each(theta: FloatArray, sizes: FloatArray) -> FloatArray:
    """Return theta (parameter,) with each of the sizes (size,) of one candidate more, (size, parameter)."""
    return np.column_stack([np.repeat(theta[None], len(sizes), axis=0), sizes])


def _ranked(
    base: ModalFit,
    candidate: Candidate,
    sizes: FloatArray,
    changes: FloatArray,
    masks: BoolArray,
    groups: Sequence[Recordings],
    basis: FloatArray,
) -> list[Trial]:
    """Return the best size of a candidate in each group; ``changes`` (size, row) of what is left by its action."""
    width, neutral = candidate.width[0], candidate.neutral[0]
    masked = changes * masks[:, None]  # (group, size, row)
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
    along = np.sum(slope * left, axis=-1) - off / width**2
    step = along / precision
    cost = np.sum(left**2, axis=-1) + (off / width) ** 2 - along**2 / precision
    gain = 0.5 * (float(start @ start) - cost) - 0.5 * np.log(precision * width**2)
    best = np.argmax(gain, axis=1)
    trials = []
    for number, group in enumerate(groups):
        size = sizes[best[number]] + np.clip(step[number, best[number]], -width, width)
        least, most = candidate.lower[0], candidate.upper[0] if candidate.upper else np.inf
        inside = size if least < size < most else sizes[best[number]]
        trials.append(Trial(candidate, float(inside), group, float(gain[number, best[number]])))
    return trials
