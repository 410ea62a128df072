"""Exhaustive selection: every candidate at every place fitted alone to the output error, the least AIC wins.

AIC = sum of squares over the noise's variance + 2 x parameters. Each candidate starts at the size that the score test
finds, on short segments, which forgive a wrong start; those not far behind are fitted over whole recordings, too, where
they are compared. The nominal model is taken at its word: nothing of it is calibrated.
"""

from dataclasses import replace

import numpy as np

from benchmarks.peers.answer import Answer
from benchmarks.peers.certain import Certain, certain_of
from fe_models.causes.candidate import HarmonicCandidate
from fe_models.recordings import Dataset
from hybrid.diagnosis.contest.config import SEGMENTS
from hybrid.diagnosis.contest.growing import Lengths, continued, fit_growing
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.screening.force_screening import screen_forces
from hybrid.diagnosis.screening.screening import Screened, screen

WHOLE = 12  # candidates that are fitted over whole recordings: AIC decides among the first few
WHOLE_LAWS = 5  # of them force laws, each of which takes seconds
SHORT_ITERATIONS = 3  # of each candidate over segments, from a start that has the right size


def name_by_aic(dataset: Dataset) -> Answer:
    """Return the cause with the least AIC among all and none, with its Akaike weight."""
    certain = certain_of(dataset)
    base = fit_growing(certain.hypothesis, certain.short.theta, certain.lengths, certain.noise_model, certain.short)
    assert base is not None  # a linear system always answers
    fits = [base, *(found for trial in _first(certain) if (found := _whole(trial, certain)) is not None)]
    fits += _forced(base, certain)
    aic = np.array([aic_of(item) for item in fits])
    best = int(np.argmin(aic))
    weight = float(1 / np.exp(-(aic - aic[best]) / 2).sum())
    if best == 0:
        return Answer((), weight)
    candidate = fits[best].hypothesis.candidates[0]
    return Answer((f"{candidate.kind} {candidate.reported_location}",), weight)


def aic_of(item: Fit) -> float:
    """Return Akaike's criterion of a fit; the initial states, the same for all but a harmonic force, are left out."""
    free = sum(len(candidate.names) for candidate in item.hypothesis.candidates)
    harmonics = sum(isinstance(candidate, HarmonicCandidate) for candidate in item.hypothesis.candidates)
    recordings = sum(len(batch.data) for batch in item.batches)
    return item.chi2 + 2 * (free + 2 * harmonics * recordings)


def _first(certain: Certain) -> list[Fit]:
    """Return every candidate's fit over the shortest segments, but harmonic forces', and of those the best."""
    short, found = certain.short, []
    for trial in screen(short, certain.candidates, certain.noise_model):
        extended = certain.hypothesis.adding(trial.candidate)
        theta = np.append(short.theta, trial.start)
        item = fit(
            extended, theta, short.batches, certain.noise_model, short.states, SHORT_ITERATIONS, SEGMENTS.enough_fall
        )
        if item is not None:
            found.append(item)
    found.sort(key=aic_of)
    behind = found[0].chi2 / found[0].values  # where no candidate fits, all differ by far more than AIC expects
    kept: list[Fit] = []
    laws = 0
    for item in found[:WHOLE]:
        laws += not item.hypothesis.is_linear
        hopeless = aic_of(item) - aic_of(found[0]) > 2 * SEGMENTS.given_up_behind * max(1.0, behind)
        if not hopeless and (item.hypothesis.is_linear or laws <= WHOLE_LAWS):
            kept.append(item)
    return kept


def _whole(begun: Fit, certain: Certain) -> Fit | None:
    """Return the fit over whole recordings that goes on from one of the shortest segments."""
    cut = certain.lengths.cut
    if len(cut) == 1:
        return begun
    start = replace(begun, states=continued(begun, cut[1]))
    return fit_growing(begun.hypothesis, begun.theta, Lengths(cut[1:]), certain.noise_model, start)


def _forced(base: Fit, certain: Certain) -> list[Fit]:
    """Return fits of a harmonic force at every place, at the frequency that explains most."""
    best: dict[str, Screened] = {}
    for trial in screen_forces(base, certain.candidates, certain.noise_model):
        best.setdefault(trial.candidate.key, trial)
    fits = []
    for trial in best.values():
        extended = certain.hypothesis.adding(trial.candidate)
        states = tuple(np.concatenate([part, np.full((len(part), 2), 1e-3)], axis=1) for part in base.states)
        item = fit(extended, np.append(base.theta, trial.start), base.batches, certain.noise_model, states)
        if item is not None:
            fits.append(item)
    return fits
