"""What a few recordings show by themselves, beside the drawn structure and beside that with what was found."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.matrix_effects import model_with_effects
from fe_models.recordings import Dataset, Recording
from fe_models.structure import Structure
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.modes_and_motion.paired_modes import PairedMode
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.diagnosis.recorded.faulty_channels import usable
from hybrid.identification.frequency_response import FrequencyResponse, frequency_response
from hybrid.identification.recording_comparison import Compared, beside, compare_recordings

MOST_SHOWN = 3  # recordings: modes of one take seconds, and figures of more take pages
NOT_COMPARED = "The modes of the recordings could not be held against the structure by themselves ({reason})."


@dataclass(frozen=True)
class Seen:
    """Of the recordings of the ``dataset``: their modes beside the ``drawn`` structure and beside the ``extended`` one,
    frequency ``responses`` of those under known forces; None where there is none. ``notes`` say why.
    """

    dataset: Dataset
    drawn: Compared | None
    extended: Compared | None
    responses: FrequencyResponse | None
    notes: tuple[str, ...]


def nothing_seen(dataset: Dataset) -> Seen:
    """Return nothing of the recordings of a dataset."""
    return Seen(dataset, None, None, None, ())


def seen_in(dataset: Dataset, found: Answer) -> Seen:
    """Return what some recordings show: of each state one, and one that was kept for testing."""
    if not dataset.recordings:
        return nothing_seen(dataset)
    notes = list[str]()
    try:
        dataset = usable(dataset)[0]
        driven, free = dataset.parted()
        responses = None if driven is None else frequency_response(driven, extended_model(found))
    except InputError as error:
        responses, free = None, dataset.parted()[1]
        notes.append(NOT_COMPARED.format(reason="; ".join(error.faults)))
    if free is None:
        return Seen(dataset, None, None, responses, tuple(notes))
    single = {recording.name for recording in free.recordings if len(recording.data) == 1}
    known = {name: own for name, own in found.identified.items() if name in single}
    models = _compared_models(dataset, found)
    shown = replace(free, recordings=_chosen(free.recordings, found.findings))
    try:
        drawn = compare_recordings(shown.with_model(models[0]), known=known)
        extended = beside(drawn, shown.with_model(models[1]))
    except (InputError, np.linalg.LinAlgError) as error:
        notes.append(NOT_COMPARED.format(reason=" ".join(str(error).split())))
        return Seen(shown, None, None, responses, tuple(notes))
    return Seen(shown, drawn, extended, responses, tuple(notes))


def extended_model(found: Answer) -> Structure | LinearModel:
    """Return the structure, or the matrices, with what was found."""
    if isinstance(found.extended, Structure):
        return found.extended
    return model_with_effects(found.extended.calibrated, *found.extended.effects)


def _compared_models(dataset: Dataset, found: Answer) -> tuple[Structure | LinearModel, Structure | LinearModel]:
    """Return the model as drawn and that with what was found; matrices over few coordinates, which takes no time."""
    if isinstance(found.extended, Structure):
        return dataset.model, found.extended
    return found.extended.drawn_in_few, found.extended.extended_in_few


def _chosen(recordings: Sequence[Recording], findings: Sequence[Finding]) -> tuple[Recording, ...]:
    """Return the first motion of the first recording in which each set of findings acts, then that of one for testing,
    in the order in which they were made.
    """
    states = dict[frozenset[int], int]()
    for number, recording in enumerate(recordings):
        acting = frozenset(k for k, finding in enumerate(findings) if recording.name in finding.recordings)
        states.setdefault(acting, number)
    tests = [number for number, recording in enumerate(recordings) if recording.role == "test"]
    first = dict.fromkeys([*states.values(), *tests[:1], *range(len(recordings))])
    chosen = sorted(list(first)[:MOST_SHOWN])
    return tuple(replace(recordings[number], data=recordings[number].data[:1]) for number in chosen)


def paired_modes_of(found: Answer, seen: Seen) -> tuple[PairedMode, ...]:
    """Return the measured modes beside those of both structures; none where nothing could be compared."""
    if isinstance(found, ModalDiagnosis):
        return found.modes
    if seen.drawn is None:
        return ()
    rows = list[PairedMode]()
    for number, own in enumerate(seen.drawn.recordings):
        modes, sides = own.identified, [_pairs(seen.drawn, number)]
        sides.append({} if seen.extended is None else _pairs(seen.extended, number))
        for k in sorted(set(own.shown) & (sides[0].keys() | sides[1].keys())):
            (before, mac_before), (after, mac_after) = (side.get(k, (None, None)) for side in sides)
            rows.append(
                PairedMode(
                    own.name,
                    float(modes.frequencies[k]),
                    float(modes.frequency_errors[k]),
                    float(modes.ratios[k]),
                    float(modes.ratio_errors[k]),
                    before,
                    after,
                    mac_before,
                    mac_after,
                )
            )
    return tuple(rows)


def _pairs(compared: Compared, number: int) -> dict[int, tuple[float | None, float | None]]:
    """Return frequency (Hz) and MAC of the structure's mode, by the number of the identified one."""
    own = compared.recordings[number]
    return {k: (float(compared.nominal[mode]), float(own.criterion[mode, k])) for mode, k in compared.pairs(own)}
