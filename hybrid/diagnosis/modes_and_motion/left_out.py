"""Recordings for training that a fit has not seen, so that forecasts of them are fair without any for testing."""

from collections.abc import Sequence
from dataclasses import dataclass

from fe_models.recordings import Dataset
from hybrid.diagnosis.discrepancy.config import SETTLING
from hybrid.diagnosis.discrepancy.expected_modes import ExpectedModes
from hybrid.diagnosis.discrepancy.law_fit import LawFit
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace
from hybrid.diagnosis.discrepancy.recorded_motions import errors_of_state
from hybrid.diagnosis.fitting.config import FORECAST
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modes_and_motion.first_fifth import spaces_of, with_first_fifth_of
from hybrid.diagnosis.modes_and_motion.motion_fit import MotionFit, kept_for_testing, without_recordings


@dataclass(frozen=True, eq=False)
class LeftOut:
    """A ``dataset`` whose recordings for testing were not seen when the others were ``measured`` and fitted: the modes
    of all states, ``spaces``, with a force ``law`` in them; the number of the ``state`` to take, None where the
    recordings themselves tell.
    """

    dataset: Dataset
    measured: ModalData
    spaces: Sequence[ModalSpace]
    law: LawFit | None = None
    state: int | None = None

    @classmethod
    def of(cls, dataset: Dataset, motion: MotionFit) -> "LeftOut":
        """Return what the ``motion`` of the recordings for training was fitted as."""
        return cls(dataset, motion.measured, _spaces(dataset, motion), motion.law)


def in_turn(dataset: Dataset, motion: MotionFit) -> list[LeftOut]:
    """Return what was fitted without some of the recordings for training, until each was left out; of a state never
    all. A recording alone in its state is left out but for the modes of its first fifth; these show no force law, and
    with one recordings are left out whatever their state.
    """
    count, states = len(dataset.select("train")), dict[tuple[int, ...], list[int]]()
    for number in range(count if count > 1 else 0):
        states.setdefault(() if motion.law else motion.fit.claim.idle_in(number), []).append(number)
    shared = [own for own in states.values() if len(own) > 1]
    folds = min(FORECAST.max_folds, max(map(len, shared), default=0))
    groups = [sorted(number for own in shared for number in own[fold::folds]) for fold in range(folds)]
    apart = [without_recordings(motion, dataset, group) for group in groups]
    parts = [LeftOut.of(*part) for part in apart if part is not None]
    singles = [_left_alone(dataset, motion, own[0]) for own in states.values() if len(own) == 1]
    return parts + [part for part in singles if part is not None]


def _left_alone(dataset: Dataset, motion: MotionFit, recording: int) -> LeftOut | None:
    """Return what was fitted to all but one recording, and to the modes of its first fifth; None where it has none."""
    measured = with_first_fifth_of(dataset, motion.measured, recording)
    spaces = [] if measured is None else spaces_of(dataset, measured, motion.fit, recording)
    if measured is None or not spaces:
        return None
    return LeftOut(kept_for_testing(dataset, [recording]), measured, spaces, state=0)


def _spaces(dataset: Dataset, motion: MotionFit) -> list[ModalSpace]:
    """Return the modes of each state that recordings distinguish, where recordings have them."""
    numbers = [number for number, recording in enumerate(dataset.select("train")) for _ in recording.data]
    claim, settled = motion.fit.claim, motion.track.discrepancy.whole <= SETTLING.max_whole
    states: dict[tuple[int, ...], ExpectedModes] = {}
    for number, own in zip(numbers, motion.track.expected.modes, strict=True):
        states.setdefault(claim.idle_in(number), own)
    if settled or motion.law is not None:
        return [own.space for own in states.values()]
    found = []
    for idle, own in states.items():
        recordings = [number for number in dict.fromkeys(numbers) if claim.idle_in(number) == idle]
        found.append(own.moved_by(errors_of_state(motion.measured, motion.fit, own, recordings)).space)
    return found
