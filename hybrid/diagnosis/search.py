"""The contest: every cause at every place is screened, the promising ones are fitted, and the fits compared."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fe_models.dofs import FloatArray
from hybrid.calibration import nothing
from hybrid.diagnosis.candidates import Candidate
from hybrid.diagnosis.fitting import ENOUGH, Fit, Frame, fit
from hybrid.diagnosis.hypothesis import Hypothesis
from hybrid.diagnosis.records import Batch
from hybrid.diagnosis.scanning import scan
from hybrid.diagnosis.screening import Screened, screen, screen_forces

PIECES = (10, 3, 1)  # segments that recordings are cut into, one after the other: short ones forgive a wrong start
FEWEST = 8  # values a segment at least, for each of its initial state's entries
KEPT = 10  # candidates kept from the screening of each length
KEPT_LAWS = 5  # of them force laws, which take far longer to fit
FORCED = 6.0  # the same for each recording of a harmonic force, whose two entries of the initial state cost as much
HOPEFUL = 6.0  # fall in the sum of squares that the score test must promise; less cannot outweigh the prior odds
BEHIND = 30.0  # in half the tempered sum of squares over short segments: too far behind to be fitted over whole ones
ALWAYS = 3  # candidates that are fitted over whole recordings, however far behind
CLOSE_ENOUGH = 1.0  # fall in the sum of squares at which fits of segments stop; they are only starts


@dataclass(frozen=True)
class Lengths:
    """The recordings ``cut`` into ever longer segments; the last are whole."""

    cut: tuple[tuple[Batch, ...], ...]

    @property
    def whole(self) -> tuple[Batch, ...]:
        """The recordings."""
        return self.cut[-1]


def lengths_of(batches: tuple[Batch, ...], states: int) -> Lengths:
    """Return the segments; those too short to tell an initial state are left out."""
    shortest, sensors = min(batch.samples for batch in batches), batches[0].data.shape[2]
    usable = [pieces for pieces in PIECES[:-1] if shortest // pieces * sensors >= FEWEST * states]
    cut = []
    for pieces in usable:
        first = usable[0]
        share = first // pieces  # of the shortest segments in one of these, so that they begin where a short one does
        cut.append(tuple(batch.cut(batch.samples // first * share) for batch in batches))
    return Lengths((*cut, batches))


def continued(fit: Fit, longer: tuple[Batch, ...]) -> tuple[FloatArray, ...]:
    """Return where the initial states of longer segments begin: at those of the short ones with the same start."""
    states = []
    for own, short, long in zip(fit.states, fit.batches, longer, strict=True):
        by_recording = own.reshape(len(short.names), short.pieces, -1)
        every = short.pieces // long.pieces
        states.append(by_recording[:, ::every][:, : long.pieces].reshape(len(long.names) * long.pieces, -1))
    return tuple(states)


def fit_growing(
    hypothesis: Hypothesis, theta: FloatArray, lengths: Lengths, frame: Frame, start: Fit | None = None
) -> Fit | None:
    """Return the fit over whole recordings, reached over segments of growing length; None where it fails.

    ``start``: a fit of the shortest segments whose initial states to begin with.
    """
    present, states = None, None if start is None else start.states
    for batches in lengths.cut:
        if present is not None:
            theta, states = present.theta, continued(present, batches)
        last = batches is lengths.whole
        present = fit(hypothesis, theta, batches, frame, states, enough=ENOUGH if last else CLOSE_ENOUGH)
        if present is None:
            return None
    return present


@dataclass(frozen=True)
class Contest:
    """``base``: the fit that others are held against; ``fits`` of it with one candidate more, best evidence first."""

    base: Fit
    fits: tuple[Fit, ...]


def contest(
    hypothesis: Hypothesis,
    theta: FloatArray,
    candidates: tuple[Candidate, ...],
    lengths: Lengths,
    frame: Frame,
    start: Fit | None = None,
    advance: Callable[[], object] = nothing,
    kept: int = KEPT,
) -> Contest | None:
    """Return the contest of all ``candidates`` on top of ``hypothesis``; None where that itself cannot be fitted."""
    short = fit(hypothesis, theta, lengths.cut[0], frame, None if start is None else start.states)
    if short is None:
        return None
    base = fit_growing(hypothesis, short.theta, lengths, frame, short)
    advance()
    if base is None:
        return None
    present = {candidate.key for candidate in hypothesis.candidates}
    others = tuple(candidate for candidate in candidates if candidate.key not in present)
    ranked = [screen(short, others, frame), screen(base, others, frame), scan(short, others, frame)]
    forces = [trial for trial in screen_forces(base, others, frame) if trial.gain > FORCED * _recordings(base)]
    advance()
    fits = [_refined(hypothesis, base, trial, frame) for trial in forces[:ALWAYS]]
    starts = _promising(ranked, kept)
    first: list[tuple[Fit, Screened]] = []
    for trial in starts:
        extended = hypothesis.adding(trial.candidate)
        begun = fit(extended, trial.theta(short), short.batches, frame, short.states, 8, CLOSE_ENOUGH)
        if begun is not None:
            first.append((begun, trial))
        advance()
    first.sort(key=lambda pair: pair[0].cost)
    if first:
        temper = max(1.0, first[0][0].chi2 / first[0][0].values)
        for rank, (begun, _) in enumerate(first):
            if rank >= ALWAYS and (begun.cost - first[0][0].cost) / 2 / temper > BEHIND:
                continue
            fits.append(
                fit_growing(
                    begun.hypothesis,
                    begun.theta,
                    Lengths(lengths.cut[1:]),
                    frame,
                    replace(begun, states=continued(begun, lengths.cut[1])) if len(lengths.cut) > 1 else begun,
                )
            )
            advance()
    done = [item for item in fits if item is not None]
    return Contest(base, tuple(sorted(done, key=lambda item: -item.log_evidence)))


def _recordings(item: Fit) -> int:
    return sum(len(batch.data) for batch in item.batches)


def _refined(hypothesis: Hypothesis, base: Fit, trial: Screened, frame: Frame) -> Fit | None:
    """Return the fit of a harmonic force over whole recordings, at rest in the initial states to begin with."""
    extended = hypothesis.adding(trial.candidate)
    states = tuple(np.concatenate([part, np.full((len(part), 2), 1e-3)], axis=1) for part in base.states)
    return fit(extended, trial.theta(base), base.batches, frame, states)


def _promising(ranked: list[list[Screened]], kept: int) -> list[Screened]:
    """Return the best of each ranking, not too many force laws among them, each candidate once."""
    chosen: dict[str, Screened] = {}
    for ranking in ranked:
        laws, taken = 0, 0
        for trial in ranking:
            if trial.gain <= 0 or taken >= kept or (taken >= ALWAYS and trial.gain < HOPEFUL):
                break
            if trial.candidate.is_law:
                laws += 1
                if laws > min(KEPT_LAWS, kept // 2):
                    continue
            taken += 1
            chosen.setdefault(trial.candidate.key, trial)
    return list(chosen.values())
