"""Fits of a modal model with the causes that were found in its structure."""

from dataclasses import replace
from itertools import combinations

import numpy as np
from scipy.sparse import csr_array

from fe_models.causes.candidate import Candidate, MatrixCandidate, ModeCandidate, SupportCandidate
from hybrid.diagnosis.contest.discrepancy import in_units_of
from hybrid.diagnosis.contest.evidence import Evidence
from hybrid.diagnosis.contest.growing import lengths_of, padded, reference_fits_of, short_fit
from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.nominal.modal_model import standing_for
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response.hypothesis import Hypothesis


def fits_in_modal_model(item: Fit, modal: NominalModel, setting: Setting, evidence: Evidence) -> list[Fit]:
    """Return the fits of a modal model with some or all of the causes of a fit, from where that is.

    Some: a modal model that was measured may have in it already what the structure lacks. What a mode does not say (of
    supports, of modes that it has not) is left out.
    """
    causes = item.hypothesis.candidates
    said = [i for i, cause in enumerate(causes) if _is_said(cause, modal)]
    counts = range(1, len(said) + 1)
    if any(batch.off for batch in item.batches):  # what acts in some recordings only goes by its number among all
        counts = range(len(causes), len(said) + 1)
    chosen = [subset for count in counts for subset in combinations(said, count)]
    fits = [fit_in_modal_model(item, subset, modal, setting, evidence) for subset in chosen]
    return [found for found in fits if found is not None]


def _is_said(cause: Candidate, modal: NominalModel) -> bool:
    """Return whether the modes of a modal model can have a cause."""
    if isinstance(cause, ModeCandidate):
        return cause.mode < modal.size
    return not isinstance(cause, SupportCandidate)


def fit_in_modal_model(
    item: Fit, chosen: tuple[int, ...], modal: NominalModel, setting: Setting, evidence: Evidence
) -> Fit | None:
    """Return the fit of a modal model with the ``chosen`` causes of a fit; None where it fails."""
    T = standing_for(setting.nominal, modal)
    own = item.hypothesis
    modal = replace(modal, geometry=own.nominal.geometry)
    hypothesis = Hypothesis(modal, tuple(_standing_for(own.candidates[i], T) for i in chosen))
    parts = len(modal.parts)
    damping = np.zeros(hypothesis.nuisances - parts)
    theta = np.concatenate([item.theta[:parts], damping, *(item.theta[own.slices[i]] for i in chosen)])
    noise_model = evidence.searched
    lengths = lengths_of(item.batches, hypothesis.states)
    with np.errstate(over="ignore", invalid="ignore"):  # a step that goes too far is taken back
        short = short_fit(modal, lengths, noise_model)
        start = replace(short, states=padded(short, hypothesis))
        found = reference_fits_of(hypothesis, theta, lengths, noise_model, start)
    if found is None:
        return None
    return in_units_of(evidence.noise_model, found.whole, noise_model)


def _standing_for(cause: Candidate, T: csr_array) -> Candidate:
    """Return a cause whose changes act on a modal model whose modes stand for the structure's; T (dof, dof)."""
    if not isinstance(cause, MatrixCandidate):
        return cause
    mass, damping, stiffness = (csr_array(T.T @ change @ T) for change in cause.changes)
    return replace(cause, changes=(mass, damping, stiffness))
