"""What else was considered by modes and motion: the best hypotheses, how probable each is, and what it leaves."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate
from fe_models.causes.wording import at_place, kind_words
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.misfit import misfit_of
from hybrid.diagnosis.modal.modal_data import ModalData

MAX_TOLD = 12  # hypotheses that are told; all others are less probable
NOTHING_ELSE, NO_LAW = "no cause, nominal values alone", "no force law"


@dataclass(frozen=True)
class ConsideredHypothesis:
    """A hypothesis in ``words``, its ``probability``, and what it ``leaves``: of measured modes the mean square, in
    units of what modes of one structure differ by; beside a force law the discrepancy, as a share of the motion.
    """

    words: str
    probability: float
    leaves: float


def considered_by_modes(
    measured: ModalData, fits: Sequence[ModalFit], probability: FloatArray
) -> tuple[ConsideredHypothesis, ...]:
    """Return the most probable of the ``fits``, and that of nothing wrong; ``probability`` (fit,) of each."""
    order = np.argsort(-probability, kind="stable")
    told = [int(k) for k in order[:MAX_TOLD]]
    told += [int(k) for k in order[MAX_TOLD:] if fits[k].claim.key == measured.null.key][:1]
    return tuple(
        ConsideredHypothesis(
            _words(measured, fits[k].claim),
            float(probability[k]),
            misfit_of(measured, fits[k], fits[0]) / max(len(fits[0].residual), 1),
        )
        for k in told
    )


def considered_laws(laws: LawSearch) -> tuple[ConsideredHypothesis, ...]:
    """Return the most probable force laws, and that none acts."""
    found = tuple(
        ConsideredHypothesis(_named(fit.candidate), own, fit.track.discrepancy.whole)
        for fit, own in zip(laws.fits[:MAX_TOLD], laws.probabilities[:MAX_TOLD].tolist(), strict=True)
    )
    return (*found, ConsideredHypothesis(NO_LAW, laws.none, laws.track.discrepancy.whole))


def _named(candidate: Candidate) -> str:
    return f"{kind_words(candidate.kind)} {at_place(candidate.reported_location)}"


def _words(measured: ModalData, claim: Claim) -> str:
    """Return what a claim says, in words."""
    names, told = [own.name for own in measured.recordings], []
    for candidate, acts in zip(claim.hypothesis.candidates, claim.acts, strict=True):
        own = _named(candidate)
        told.append(own if len(acts) == len(names) else f"{own} in {', '.join(names[k] for k in acts)}")
    if claim.changed:
        told.append(f"an unknown change in {', '.join(names[k] for k in claim.changed)}")
    return " and ".join(told) or NOTHING_ELSE
