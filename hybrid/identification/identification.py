"""The modes of a recording, whatever moved the structure: free decays and ambient vibration by one door."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from fe_models.recordings import Excitation
from hybrid.identification.ambient_modes import identify_ambient_modes
from hybrid.identification.excitation import Course, course_of
from hybrid.identification.free_decay_modes import identify_free_decay
from hybrid.identification.harmonics import Harmonic
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.stabilisation import Stabilisation

SAID: dict[Excitation | None, str] = {
    None: "nothing is said of what moved it",
    "free": "it is called a free decay",
    "measured": "its forces are known; they are not used here",
}


@dataclass(frozen=True)
class Identification:
    """The ``modes`` of a recording and the poles they come from (``stabilisation``); ``is_ambient``: whether it was
    taken for one under unknown forces; ``harmonics``: lines of machines that are no modes. ``note``: what a user should
    know of why it was taken so, empty where it is as stated.
    """

    modes: IdentifiedModes
    stabilisation: Stabilisation
    is_ambient: bool
    harmonics: tuple[Harmonic, ...] = ()
    note: str = ""


def identify(
    motions: Sequence[FloatArray],
    rate: float,
    first: float,
    highest: float,
    orders: IntArray,
    excitation: Excitation | None = None,
    count: int | None = None,
) -> Identification:
    """Return the modes of one recording up to ``highest`` Hz, by frequency; with ``count`` the strongest, at most so
    many.

    ``motions``: (time, sensor) each, sampled at ``rate`` Hz, of one state of the structure. ``first``: its lowest
    natural frequency, Hz. ``orders`` (sensor,): of the derivatives of displacements that sensors show.
    ``excitation``: what the user says moved it. Data that do not die away, or start again, are no free decay, whatever
    is said.
    """
    parts = [np.asarray(part, dtype=float) for part in motions]
    course = Course.GOES_ON if excitation == "ambient" else course_of(parts, rate, first, highest, orders)
    if course.may_be_free:
        modes, stabilisation = identify_free_decay(parts, rate, first, highest, orders)
        return Identification(modes if count is None else modes.strongest(count), stabilisation, is_ambient=False)
    found = identify_ambient_modes(parts, rate, first, highest, orders)
    modes = found.modes if count is None else found.modes.strongest(count)
    note = "" if excitation == "ambient" else f"although {SAID[excitation]}: it {course.value}"
    return Identification(modes, found.stabilisation, True, found.harmonics, note)
