"""What was found, as it moves: the motion of all recordings by the best claim, and the law beside it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from fe_models.recordings import Dataset
from hybrid.diagnosis.discrepancy.config import SETTLING
from hybrid.diagnosis.discrepancy.law_fit import LawFit, fit_law, settled_law
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.discrepancy.recorded_motions import track_of
from hybrid.diagnosis.discrepancy.settling import settled
from hybrid.diagnosis.discrepancy.tracking import Track
from hybrid.diagnosis.fitting.config import FORECAST
from hybrid.diagnosis.modal.evidence import ModalFit, fit_claim
from hybrid.diagnosis.modal.modal_data import ModalData


@dataclass(frozen=True, eq=False)
class Found:
    """A ``track`` of the recordings for training by the claim of a ``fit``, and the force ``law`` in it, if any."""

    measured: ModalData
    fit: ModalFit
    track: Track
    law: LawFit | None


def found_by_modes(dataset: Dataset, measured: ModalData, best: ModalFit) -> Found | None:
    """Return the motion by the ``best`` claim alone; None where that has no modes."""
    item = _settled_track(dataset, measured, best)
    return None if item is None else Found(measured, best, item, None)


def found_beside(known: Found, laws: LawSearch) -> Found:
    """Return the motion with the law that is named beside the claim of what is ``known`` of it; this where none is."""
    return known if laws.named is None else replace(known, track=laws.named.track, law=laws.named)


def found_instead(dataset: Dataset, measured: ModalData, best: ModalFit, law: LawFit) -> Found | None:
    """Return the motion with a ``law`` that was sought in the place of all causes, fitted anew beside the ``best``
    claim of the modes without it; None where that has no modes.
    """
    item = track_of(dataset, measured, best)
    if item is None:
        return None
    again = settled_law(fit_law(item, measured.nominal, law.candidate, law.theta), measured.nominal)
    return Found(measured, best, again.track, again)


def without_recordings(known: Found, dataset: Dataset, left_out: Sequence[int]) -> tuple[Dataset, Found] | None:
    """Return the dataset with those of its recordings for training that are ``left_out``, by number, kept for testing,
    and what was found fitted to the others alone; None where these do not have it.
    """
    train = dataset.select("train")
    kept = [number for number in range(len(train)) if number not in left_out]
    parted = kept_for_testing(dataset, left_out)
    measured = replace(known.measured, recordings=tuple(known.measured.recordings[number] for number in kept))
    claim, idle = known.fit.claim.within(kept)
    theta = known.fit.theta[known.fit.claim.hypothesis.parameters_of(idle)]
    errors = known.fit.inflation.items()
    inflation = {(kept.index(recording), mode): own for (recording, mode), own in errors if recording in kept}
    fit = fit_claim(measured, claim, theta, known.fit.sizes, FORECAST.fold_iterations, False, inflation)
    if fit is None:
        return None
    if known.law is None:
        item = _settled_track(parted, measured, fit)
        return None if item is None else (parted, Found(measured, fit, item, None))
    item = track_of(parted, measured, fit)
    if item is None:
        return None
    law = fit_law(item, measured.nominal, known.law.candidate, known.law.theta)
    return parted, Found(measured, fit, law.track, law)


def kept_for_testing(dataset: Dataset, left_out: Sequence[int]) -> Dataset:
    """Return the recordings for training of a dataset, those ``left_out``, by number, for testing."""
    train = enumerate(dataset.select("train"))
    return replace(dataset, recordings=tuple(replace(r, role="test") if n in left_out else r for n, r in train))


def _settled_track(dataset: Dataset, measured: ModalData, fit: ModalFit) -> Track | None:
    """Return the motion by a claim, its modes moved to where the recordings have them: not where it strays from any,
    so that its phases say less of them than identification does.
    """
    item = track_of(dataset, measured, fit)
    return item if item is None or item.discrepancy.whole > SETTLING.most_whole else settled(item, ())
