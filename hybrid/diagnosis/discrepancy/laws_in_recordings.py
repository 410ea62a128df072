"""Force laws in the recordings of a dataset: searched for once modes were asked for causes, and taken away."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.discrepancy.config import LAW_FIT
from hybrid.diagnosis.discrepancy.law_fit import fit_law, force_along, settled_law
from hybrid.diagnosis.discrepancy.law_search import LawSearch, search_laws
from hybrid.diagnosis.discrepancy.linearisation import pushed_by
from hybrid.diagnosis.discrepancy.recorded_motions import track_of
from hybrid.diagnosis.discrepancy.tracking import Track, samples_in, shortened
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit, as_drawn
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.recorded.batches import measured_columns


def may_have_laws(dataset: Dataset, measured: ModalData) -> bool:
    """Return whether motion tells force laws: free motion, of one sampling rate, where the structure has none of its
    own.
    """
    free = [recording for recording in dataset.select("train") if not recording.is_driven]
    alone = len(free) == len(dataset.select("train")) > 0 and len(dataset.sampling_rates) == 1
    return alone and not measured.nominal.laws


def laws_in(
    dataset: Dataset, drawn: tuple[ModalData, ModalFit], found: tuple[ModalData, ModalFit], best: Track, odds: float
) -> LawSearch:
    """Return the force laws in the training recordings.

    First in the place of all other causes: beside the structure as it was ``drawn``, its values as exact as was stated,
    or as the modes have it, ``found``, whichever follows the recordings better; a strong law bends the modes and leads
    nominal values astray. Where the ``best`` claim of all modes, with its log ``odds`` beforehand, follows them better
    still, only what it leaves is asked for a law; so it is at first where that claim is of some recordings alone.
    """
    samples = samples_in(best, LAW_FIT.most_values)
    claim, every = best.claimed.fit.claim, set(range(len(found[0].recordings)))
    if claim.hypothesis.candidates and best.discrepancy.is_small:
        return _beside(best, found[0], samples)
    measured, fit = drawn
    bare = [
        (track_of(dataset, measured, as_drawn(measured, fit), ErrorSizes()), measured),
        (track_of(dataset, *found), found[0]),
    ]
    known = [(item, own) for item, own in bare if item is not None]
    if not known:
        return _beside(best, found[0], samples)
    bare_best, own = max(known, key=lambda pair: pair[0].evidence)
    if any(set(acts) < every for acts in (*claim.acts, claim.changed) if acts):
        return _alone(_beside(best, found[0], samples), bare_best, own, best.evidence + odds)
    instead = _searched(bare_best, own, samples)
    if not claim.hypothesis.candidates or instead.log_evidence > shortened(best, samples).evidence + odds:
        return _of_all(instead, bare_best)
    return _beside(best, found[0], samples)


def _beside(best: Track, measured: ModalData, samples: int) -> LawSearch:
    """Return the laws beside the claim of a track."""
    return replace(_of_all(_searched(best, measured, samples), best), replaces_causes=False)


def _alone(laws: LawSearch, bare: Track, measured: ModalData, claimed: float) -> LawSearch:
    """Return the law that is named beside a claim without that, on a ``bare`` track, where it alone is more probable
    than the claim alone, ``claimed``: under a law modes differ with amplitude, from one recording to the next. Which
    law it is, was told beside the claim: its rivals and probabilities stay those.
    """
    if laws.named is None:
        return laws
    nominal = measured.nominal
    alone = settled_law(fit_law(bare, nominal, laws.named.candidate, laws.named.theta), nominal)
    if alone.evidence <= claimed:
        return laws
    return replace(laws, track=bare, nominal=nominal, fits=(alone, *laws.fits[1:]), replaces_causes=True)


def _searched(item: Track, measured: ModalData, samples: int) -> LawSearch:
    """Return the laws that a track asks for, by the first part of long motions, of so many ``samples`` in all: none
    where the filter sees no discrepancy.
    """
    short = shortened(item, samples)
    if item.discrepancy.is_small:
        return LawSearch(short, measured.nominal, (), np.zeros(0), 1.0, 0.0)
    return search_laws(short, measured)


def _of_all(laws: LawSearch, item: Track) -> LawSearch:
    """Return the search with the law that is named, if any, fitted to the whole of the motions of a track; without one
    that cannot follow these.
    """
    nominal, named = laws.nominal, laws.named
    seen = [len(own.data) for own in laws.track.followed]
    if named is None or seen == [len(own.data) for own in item.followed]:
        return laws
    whole = settled_law(fit_law(item, nominal, named.candidate, named.theta), nominal)
    if np.isfinite(whole.evidence):
        return replace(laws, track=item, fits=(whole, *laws.fits[1:]))
    lost, rest = float(laws.probabilities[0]), laws.probabilities[1:]
    return _of_all(replace(laws, fits=laws.fits[1:], probabilities=rest, other=laws.other + lost), item)


def without_law(dataset: Dataset, laws: LawSearch) -> Dataset:
    """Return the dataset with training recordings less what the named law does in them."""
    best, columns = laws.named, list(measured_columns(dataset))
    if best is None:
        return dataset
    law, done = force_along(laws.nominal, best.candidate, best.theta), list[FloatArray]()
    for space, between in zip(best.track.spaces, best.track.between, strict=True):
        added, shown = pushed_by(law, space, between)
        done.append(space.motion(added) @ space.output.T + shown)
    made = iter(done)

    def less(recording: Recording) -> Recording:
        if recording.role != "train":
            return recording
        data = recording.data.copy()
        for motion in data:
            motion[:, columns] -= next(made)
        return replace(recording, data=data)

    return replace(dataset, recordings=tuple(less(recording) for recording in dataset.recordings))
