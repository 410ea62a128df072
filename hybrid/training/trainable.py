"""A dataset as the hybrid model takes it: at one rate, each recording with what moved it, knocks without their force
where samples do not tell it.
"""

from collections.abc import Mapping
from dataclasses import replace

from fe_models.errors import raise_faults
from fe_models.nominal import nominal_modes
from fe_models.recordings import Dataset, Recording
from hybrid.identification.excitation import Course
from hybrid.identification.unstated_excitation import unstated_course
from hybrid.known_loads.quiet_loads import with_quiet_loads
from hybrid.known_loads.short_knocks import without_short_knocks

TOLD_BY_DATA = (
    'nothing is said of what moved it, and it {course}; where it is a free decay all the same, say excitation = "free"'
)
NOT_LEARNED = (
    "whose forces nobody knows: no forecast can be held against it, so that nothing is learned from it. Train on free"
    ' decays or under known loads, and give it role = "test": the motion at all nodes is then estimated from it'
)


def trainable(dataset: Dataset) -> Dataset:
    """Return the dataset to train on, and to test; `InputError` where unknown forces drove recordings for training.

    Notes say what was taken otherwise than it is stated. What is trainable stays as it is.
    """
    dataset.require_recordings("training")
    known = at_one_rate(dataset)
    driven = _driven(known, float(nominal_modes(known, 1).frequencies.min())) if _asked(known) else {}
    faults = list[str]()
    for recording in known.select("train"):
        if recording.name in driven:
            told = TOLD_BY_DATA.format(course=driven[recording.name].value)
            faults.append(f"recording {recording.name!r} is ambient vibration ({told}), {NOT_LEARNED}")
        elif recording.excitation == "ambient":
            faults.append(f"recording {recording.name!r} is ambient vibration, {NOT_LEARNED}")
    raise_faults(faults)
    return _taken(known, driven)


def at_one_rate(dataset: Dataset) -> Dataset:
    """Return the dataset at one rate; of knocks that samples do not tell what comes after them alone, with a note."""
    known, quiet = with_quiet_loads(dataset.of_one_rate("training"))
    known, knocked = without_short_knocks(known)
    return replace(known, notes=(*known.notes, *quiet, *knocked)) if quiet or knocked else known


def as_moved(dataset: Dataset, first: float) -> Dataset:
    """Return the dataset with what moved each recording, told by its data where nobody says it, and notes on that.

    ``first``: the structure's lowest natural frequency, Hz.
    """
    return _taken(dataset, _driven(dataset, first))


def taken_as_ambient(name: str, course: Course) -> str:
    """Return a note on a recording that is."""
    return f"recording {name!r} is taken as ambient vibration: {TOLD_BY_DATA.format(course=course.value)}"


def _driven(dataset: Dataset, first: float) -> dict[str, Course]:
    """Return how recordings go on of which nothing is said and that something unknown drives, by name."""
    found = {
        each.name: unstated_course(each, dataset.sensors, dataset.rate_of(each), dataset.lowpass, first)
        for each in dataset.recordings
    }
    return {name: course for name, course in found.items() if course is not None}


def _asked(dataset: Dataset) -> list[Recording]:
    """Return the recordings of which nothing is said."""
    return [each for each in dataset.recordings if each.excitation is None and not each.is_driven]


def _taken(dataset: Dataset, driven: Mapping[str, Course]) -> Dataset:
    asked = {recording.name for recording in _asked(dataset)}
    if not asked:
        return dataset
    recordings = tuple(
        replace(each, excitation="ambient" if each.name in driven else "free") if each.name in asked else each
        for each in dataset.recordings
    )
    notes = [taken_as_ambient(name, course) for name, course in driven.items()]
    return replace(dataset, recordings=recordings, notes=(*dataset.notes, *notes))
