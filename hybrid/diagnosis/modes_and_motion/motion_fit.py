"""The motion of all recordings as it was explained: by the best claim, and by the law beside it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from fe_models.recordings import Dataset
from hybrid.diagnosis.discrepancy.config import SETTLING
from hybrid.diagnosis.discrepancy.law_fit import LawFit, fit_law, refitted_law
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.discrepancy.recorded_motions import track_of
from hybrid.diagnosis.discrepancy.settling import settled
from hybrid.diagnosis.discrepancy.tracking import Track
from hybrid.diagnosis.fitting.config import FORECAST
from hybrid.diagnosis.modal.evidence import ModalFit, Start, fit_claim
from hybrid.diagnosis.modal.modal_data import ModalData


@dataclass(frozen=True, eq=False)
class MotionFit:
    """A ``track`` of the recordings for training by the claim of a ``fit``, and the force ``law`` in it, if any."""

    measured: ModalData
    fit: ModalFit
    track: Track
    law: LawFit | None

    def with_named_law(self, laws: LawSearch) -> "MotionFit":
        """Return the motion with the law that is named beside the claim; the same where none is."""
        return self if laws.named is None else replace(self, track=laws.named.track, law=laws.named)


def motion_by_claim(dataset: Dataset, measured: ModalData, best: ModalFit) -> MotionFit | None:
    """Return the motion by the ``best`` claim alone; None where that has no modes."""
    track = _settled_track(dataset, measured, best)
    return None if track is None else MotionFit(measured, best, track, None)


def motion_by_law(dataset: Dataset, measured: ModalData, best: ModalFit, law: LawFit) -> MotionFit | None:
    """Return the motion with a ``law`` that was sought in the place of all causes, fitted anew beside the ``best``
    claim of the modes without it; None where that has no modes.
    """
    track = track_of(dataset, measured, best)
    if track is None:
        return None
    again = refitted_law(track, law)
    return MotionFit(measured, best, again.track, again)


def without_recordings(
    motion: MotionFit, dataset: Dataset, left_out: Sequence[int]
) -> tuple[Dataset, MotionFit] | None:
    """Return the dataset with those of its recordings for training that are ``left_out``, by number, kept for testing,
    and the motion fitted to the others alone; None where these do not have it.
    """
    kept = [number for number in range(len(dataset.select("train"))) if number not in left_out]
    parted = kept_for_testing(dataset, left_out)
    measured = replace(motion.measured, recordings=tuple(motion.measured.recordings[number] for number in kept))
    claim, idle = motion.fit.claim.within(kept)
    theta = motion.fit.theta[motion.fit.claim.hypothesis.parameters_of(idle)]
    factors = motion.fit.inflation.items()
    inflation = {(kept.index(recording), mode): own for (recording, mode), own in factors if recording in kept}
    start = Start(claim, theta, motion.fit.sizes, inflation)
    fit = fit_claim(measured, start, FORECAST.fold_iterations, errors_too=False)
    if fit is None:
        return None
    if motion.law is None:
        track = _settled_track(parted, measured, fit)
        return None if track is None else (parted, MotionFit(measured, fit, track, None))
    track = track_of(parted, measured, fit)
    if track is None:
        return None
    law = fit_law(track, motion.law.candidate, motion.law.theta)
    return parted, MotionFit(measured, fit, law.track, law)


def kept_for_testing(dataset: Dataset, left_out: Sequence[int]) -> Dataset:
    """Return the recordings for training of a dataset, those ``left_out``, by number, for testing."""
    train = enumerate(dataset.select("train"))
    return replace(dataset, recordings=tuple(replace(r, role="test") if n in left_out else r for n, r in train))


def _settled_track(dataset: Dataset, measured: ModalData, fit: ModalFit) -> Track | None:
    """Return the motion by a claim, its modes moved to where the recordings have them: not where it strays from any,
    so that its phases say less of them than identification does.
    """
    track = track_of(dataset, measured, fit)
    return track if track is None or track.discrepancy.whole > SETTLING.max_whole else settled(track, ())
