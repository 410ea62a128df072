"""What was found, as it moves: the motion of all recordings by the best claim, and the law beside it."""

from dataclasses import dataclass, replace

from fe_models.recordings import Dataset
from hybrid.diagnosis.discrepancy.law_fit import LawFit, fit_law, settled_law
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.discrepancy.recorded_motions import track_of
from hybrid.diagnosis.discrepancy.settling import settled
from hybrid.diagnosis.discrepancy.tracking import Track
from hybrid.diagnosis.modal.claim import Measured
from hybrid.diagnosis.modal.evidence import ModalFit


@dataclass(frozen=True, eq=False)
class Found:
    """A ``track`` of the recordings for training by the claim of a ``fit``, and the force ``law`` in it, if any."""

    measured: Measured
    fit: ModalFit
    track: Track
    law: LawFit | None


def found_by_modes(dataset: Dataset, measured: Measured, best: ModalFit) -> Found | None:
    """Return the motion by the ``best`` claim alone; None where that has no modes."""
    item = track_of(dataset, measured, best)
    return None if item is None else Found(measured, best, settled(item, ()), None)


def found_beside(known: Found, laws: LawSearch) -> Found:
    """Return the motion with the law that is named beside the claim of what is ``known`` of it; this where none is."""
    return known if laws.named is None else replace(known, track=laws.named.track, law=laws.named)


def found_instead(dataset: Dataset, measured: Measured, best: ModalFit, law: LawFit) -> Found | None:
    """Return the motion with a ``law`` that was sought in the place of all causes, fitted anew beside the ``best``
    claim of the modes without it; None where that has no modes.
    """
    item = track_of(dataset, measured, best)
    if item is None:
        return None
    again = settled_law(fit_law(item, measured.nominal, law.candidate, law.theta), measured.nominal)
    return Found(measured, best, again.track, again)
