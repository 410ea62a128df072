"""What the user should know beside the findings: of modes that do not fit, and of motion that no law explains."""

from collections.abc import Sequence

import numpy as np

from fe_models.causes.wording import at_place, place_words
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.discrepancy.size import RemainingDiscrepancy
from hybrid.diagnosis.modal.config import CONCLUSION
from hybrid.diagnosis.modal.error_sizes import MAX_STATED_SCALE
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modes_and_motion.relative_stiffness import RelativeStiffness
from hybrid.diagnosis.modes_and_motion.unmatched_modes import UnmatchedModes

CHANGES_WITH_TIME = (
    "within a recording the motion strays from that of any structure with constant values, each mode by {size:.1%} of"
    " itself a radian, and {share:.1%} of what sensors show is of no mode of it: frequency or damping change with"
    " amplitude or time, or modes are missing, and no force law on the list explains that"
)
DOUBTED = (
    "what {name} shows at {listed} Hz is that of no structure that has the other modes, too: it was given little weight"
)
EXCHANGED = (
    "at {listed} Hz {name} has frequencies of the structure's modes with the shapes of others of these: check whether"
    " shapes were exchanged"
)
UNKNOWN = "{name} shows modes that the structure does not have, at {listed} Hz"
COMBINED = (
    "what {name} shows at {listed} Hz is at multiples, sums or differences of its modes' frequencies: no modes, but"
    " what a motion that is not linear makes of them"
)
RATIOS = (
    "these modes tell ratios of stiffnesses better than a factor that all share: over the mean of the others, {said}"
    " times as drawn"
)
MAX_RATIOS = 3  # that are mentioned
TWO_AT_ONE_PLACE = (
    "a force law and another cause at the very place of it are seldom two: one thing that is not on the list may look"
    " like both"
)
MIN_MENTIONED_PROBABILITY = 0.02  # of a law that is not named


def notes_on_modes(measured: ModalData, best: ModalFit, unmatched: Sequence[UnmatchedModes]) -> tuple[str, ...]:
    """Return what the user should know: changes without a name, and modes that the structure does not have
    (``unmatched``, of each recording).
    """
    notes = []
    if best.claim.changed:
        names = ", ".join(measured.recordings[recording].name for recording in best.claim.changed)
        notes.append(f"the structure differed in {names}, and no single cause on the list explains the change")
    for recording, (own, alone) in enumerate(zip(measured.recordings, unmatched, strict=True)):
        said = ((EXCHANGED, alone.exchanged), (UNKNOWN, alone.others), (COMBINED, alone.combinations))
        notes += [words.format(name=own.name, listed=_in_hertz(own, modes)) for words, modes in said if modes]
        paired = set(best.pairs.measured[best.pairs.recording == recording].tolist())
        doubted = [
            mode
            for (where, mode), factors in best.inflation.items()
            if where == recording and mode in paired and factors.frequency > CONCLUSION.doubted_sigma
        ]
        if doubted:
            notes.append(DOUBTED.format(name=own.name, listed=_in_hertz(own, doubted)))
    scale = best.sizes.stiffness_scale
    if scale > MAX_STATED_SCALE:
        notes.append(f"stiffnesses are off by {scale:.0f} times what the dataset calls normal")
    return tuple(notes)


def _in_hertz(own: MeasuredModes, modes: Sequence[int]) -> str:
    """Return the frequencies of some of a recording's modes, in words."""
    return ", ".join(f"{frequency:.4g}" for frequency in np.sort(np.exp(own.log_omega[list(modes)]) / (2 * np.pi)))


def note_on_ratios(measured: ModalData, ratios: Sequence[RelativeStiffness]) -> tuple[str, ...]:
    """Return a note on the stiffnesses that are off beside the others, those that are farthest off."""
    farthest = sorted(ratios, key=lambda own: -abs(np.log(own.factor)))[:MAX_RATIOS]
    parts = measured.nominal.parts
    said = [f"{place_words(parts[own.part].location)} {own.factor:.2f} +- {own.error:.1g}" for own in farthest]
    return (RATIOS.format(said=", ".join(said)),) if said else ()


def notes_on_motion(laws: LawSearch | None, remaining: RemainingDiscrepancy | None) -> tuple[str, ...]:
    """Return what the user should know of how the motion differs from what structure and causes do by themselves."""
    if laws is None or remaining is None or remaining.after.is_usual:
        return ()
    about = CHANGES_WITH_TIME.format(**vars(remaining.after))
    both = zip(laws.fits, laws.probabilities, strict=True)
    alike = [fit.candidate for fit, own in both if own >= MIN_MENTIONED_PROBABILITY]
    if laws.named is None and alike:
        about += f"; {alike[0].kind.replace('_', ' ')} {at_place(alike[0].reported_location)} is most like it"
    return (about,)
