"""What the user should know beside the findings: of modes that do not fit, and of motion that no law explains."""

import numpy as np

from fe_models.causes.wording import at_place
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.discrepancy.size import RemainingDiscrepancy
from hybrid.diagnosis.modal.config import CONCLUSION
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData

CHANGES_WITH_TIME = (
    "within a recording the motion strays from that of any structure with constant values, each mode by {size:.1%} of"
    " itself a radian, and {share:.1%} of what sensors show is of no mode of it: frequency or damping change with"
    " amplitude or time, or modes are missing, and no force law on the list explains that"
)
DOUBTED = (
    "what {name} shows at {listed} Hz is that of no structure that has the other modes, too: it was given little weight"
)
TWO_AT_ONE_PLACE = (
    "a force law and another cause at the very place of it are seldom two: one thing that is not on the list may look"
    " like both"
)
MIN_MENTIONED_PROBABILITY = 0.02  # of a law that is not named


def notes_on_modes(measured: ModalData, best: ModalFit) -> tuple[str, ...]:
    """Return what the user should know: changes without a name, modes that the structure does not have."""
    notes = []
    if best.claim.changed:
        names = ", ".join(measured.recordings[recording].name for recording in best.claim.changed)
        notes.append(f"the structure differed in {names}, and no single cause on the list explains the change")
    for recording, own in enumerate(measured.recordings):
        paired = set(best.pairs.measured[best.pairs.recording == recording].tolist())
        alone = [np.exp(log) / (2 * np.pi) for k, log in enumerate(own.log_omega) if k not in paired]
        if alone:
            listed = ", ".join(f"{frequency:.4g}" for frequency in sorted(alone))
            notes.append(f"{own.name} shows modes that the structure does not have, at {listed} Hz")
        doubted = [
            np.exp(own.log_omega[mode]) / (2 * np.pi)
            for (where, mode), factors in best.inflation.items()
            if where == recording and mode in paired and factors.frequency > CONCLUSION.doubted_sigma
        ]
        if doubted:
            listed = ", ".join(f"{frequency:.4g}" for frequency in sorted(doubted))
            notes.append(DOUBTED.format(name=own.name, listed=listed))
    scale = best.sizes.stiffness_scale
    if scale > CONCLUSION.worth_a_note:
        notes.append(f"stiffnesses are off by {scale:.0f} times what the dataset calls normal")
    return tuple(notes)


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
