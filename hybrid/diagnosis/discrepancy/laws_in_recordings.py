"""Force laws in the recordings of a dataset: searched for once modes were asked for causes, and taken away."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from hybrid.diagnosis.discrepancy.config import LAW_FIT
from hybrid.diagnosis.discrepancy.law_fit import LawFit, force_along, refitted_law
from hybrid.diagnosis.discrepancy.law_search import LawSearch, search_laws
from hybrid.diagnosis.discrepancy.linearisation import pushed_by
from hybrid.diagnosis.discrepancy.recorded_motions import track_of
from hybrid.diagnosis.discrepancy.tracking import Track, samples_in, shortened
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.evidence import as_drawn
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.nominal_fit import NominalFit
from hybrid.diagnosis.recorded.batches import measured_columns


def may_have_laws(dataset: Dataset, measured: ModalData) -> bool:
    """Return whether motion tells force laws: free motion, of one sampling rate, where the structure has none of its
    own.
    """
    free = [recording for recording in dataset.select("train") if not recording.is_driven]
    alone = len(free) == len(dataset.select("train")) > 0 and len(dataset.sampling_rates) == 1
    return alone and not measured.nominal.laws


def laws_in_recordings(
    dataset: Dataset, drawn: NominalFit, rebased: NominalFit, best: Track, log_odds: float
) -> LawSearch:
    """Return the force laws in the training recordings: beside the ``best`` claim of all modes, or in the place of its
    causes, where that is more probable. ``log_odds``: of that claim, beforehand.

    In the place of causes laws are sought in a bare track (`_bare_track`): a strong law bends the modes and leads
    nominal values astray. A claim of some recordings alone is taken at first: under a law modes differ with amplitude,
    but that they differ must be explained in any case.
    """
    claim, samples = best.claimed.fit.claim, samples_in(best, LAW_FIT.max_values)
    if claim.hypothesis.candidates and best.discrepancy.is_small:
        return _beside_claim(best, samples)
    bare = _bare_track(dataset, drawn, rebased)
    if bare is None:
        return _beside_claim(best, samples)
    if claim.differs_among(len(rebased.measured.recordings)):
        return _instead_of_claim(_beside_claim(best, samples), bare, best.evidence + log_odds)
    instead = _searched(bare, samples)
    if not claim.hypothesis.candidates or instead.log_evidence > shortened(best, samples).evidence + log_odds:
        return fitted_to_whole(instead, bare)
    return _beside_claim(best, samples)


def _bare_track(dataset: Dataset, drawn: NominalFit, rebased: NominalFit) -> Track | None:
    """Return the motions by nominal values alone: as ``drawn``, as exact as was stated, or as the modes have them,
    ``rebased``, whichever is more probable; None where either structure has no modes.
    """
    as_stated = as_drawn(drawn.measured, drawn.fit)
    both = (
        track_of(dataset, drawn.measured, as_stated, ErrorSizes()),
        track_of(dataset, rebased.measured, rebased.fit),
    )
    return max((track for track in both if track is not None), key=lambda track: track.evidence, default=None)


def _beside_claim(best: Track, samples: int) -> LawSearch:
    """Return the laws beside the claim of a track."""
    return replace(fitted_to_whole(_searched(best, samples), best), replaces_causes=False)


def _instead_of_claim(laws: LawSearch, bare: Track, log_posterior: float) -> LawSearch:
    """Return the law that is named beside a claim without that, in a ``bare`` track, where it alone is more probable
    than the claim alone, of that ``log_posterior``. Which law it is, was told beside the claim: its rivals and
    probabilities stay those.
    """
    if laws.named is None:
        return laws
    alone = refitted_law(bare, laws.named)
    if alone.evidence <= log_posterior:
        return laws
    return replace(laws, track=bare, fits=(alone, *laws.fits[1:]), replaces_causes=True)


def _searched(track: Track, samples: int) -> LawSearch:
    """Return the laws that a track asks for, by the first part of long motions, of so many ``samples`` in all: none
    where the filter sees no discrepancy.
    """
    short = shortened(track, samples)
    return LawSearch.without_laws(short) if track.discrepancy.is_small else search_laws(short)


def fitted_to_whole(laws: LawSearch, track: Track) -> LawSearch:
    """Return the search with the law that is named, if any, fitted to the whole of the motions of a ``track``, of which
    it may have seen the first part alone; without a law that cannot follow these.
    """
    seen, whole = ([own.samples for own in item.motions] for item in (laws.track, track))
    if laws.named is None or seen == whole:
        return laws
    fit = refitted_law(track, laws.named)
    if np.isfinite(fit.evidence):
        return replace(laws, track=track, fits=(fit, *laws.fits[1:]))
    lost, rest = float(laws.probabilities[0]), laws.probabilities[1:]
    return fitted_to_whole(replace(laws, fits=laws.fits[1:], probabilities=rest, other=laws.other + lost), track)


def without_law(dataset: Dataset, laws: LawSearch) -> Dataset:
    """Return the dataset with training recordings less what the named law does in them."""
    if laws.named is None:
        return dataset
    done, columns = iter(_done_by(laws.named)), list(measured_columns(dataset))
    recordings = []
    for recording in dataset.recordings:
        if recording.role == "train":
            data = recording.data.copy()
            for motion in data:
                motion[:, columns] -= next(done)
            recording = replace(recording, data=data)
        recordings.append(recording)
    return replace(dataset, recordings=tuple(recordings))


def _done_by(law: LawFit) -> list[FloatArray]:
    """Return what a law does in the channels (time, sensor) of each motion of its track."""
    force, found = force_along(law.track.nominal, law.candidate, law.theta), []
    for space, motion in zip(law.track.spaces, law.track.fine_motions, strict=True):
        push = pushed_by(force, space, motion)
        found.append(space.motion(push.states) @ space.output.T + push.channels)
    return found
