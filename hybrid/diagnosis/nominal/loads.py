"""What is known to move a structure, as smooth as what a sensor samples: forces, and the motion of its base.

Loads pass the filters that recordings pass, so that they hold nothing above half the sampling rate: see `interpolant`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from fe_models.base_motion import Along, BaseMotion
from fe_models.interpolant import ORDERS, Course, courses_after, courses_of
from fe_models.recordings import QUANTITIES, Dataset, Quantity, Recording
from fe_models.structure import Direction
from hybrid.known_loads.behind_lowpass import behind

LoadPlace = tuple[int, Direction]
"""Node and direction of a load."""


@dataclass(frozen=True)
class OnBase:
    """The motion of the base ``along`` a vector: its acceleration drives the structure, and sensors of the
    absolute motion show it; its velocity and displacement are shown alone.
    """

    along: Along
    quantity: Quantity = "acceleration"

    @property
    def drives(self) -> bool:
        """Whether it pushes the structure."""
        return self.quantity == "acceleration"


KnownPlace = LoadPlace | OnBase
"""Where something acts that was measured."""


@dataclass(frozen=True)
class OnMode:
    """Where a force (N / sqrt(kg), as modes are mass-normalised) acts on one nominal mode alone, by its ``number``."""

    number: int


ForcePlace = KnownPlace | OnMode
"""Where a force acts whose course is given."""


@dataclass(frozen=True)
class Loads:
    """The course of what acts at each of the ``places`` in recordings or segments of ``samples``, ``step`` (s) apart.

    ``whole`` (order, recording, time, place): the force (N, or N m; of a base m/s^2), and its derivatives by time (s),
    from each sample of whole recordings on; ``rows`` and ``begins`` (segment,): of which recording each segment is, and
    with which sample it begins.
    """

    places: tuple[ForcePlace, ...]
    whole: FloatArray
    rows: IntArray
    begins: IntArray
    samples: int
    step: float

    @classmethod
    def of(cls, places: tuple[ForcePlace, ...], courses: FloatArray, step: float) -> "Loads":
        """Return loads with ``courses`` (order, recording, time, place) of whole recordings."""
        recordings, samples = courses.shape[1:3]
        return cls(places, courses, np.arange(recordings), np.zeros(recordings, dtype=np.int64), samples, step)

    @cached_property
    def courses(self) -> FloatArray:
        """The courses (order, segment, time, place) from each sample on."""
        is_whole = self.samples == self.whole.shape[2] and np.array_equal(self.rows, np.arange(self.whole.shape[1]))
        return self.whole if is_whole else self.ahead(0.0)

    def ahead(self, time: float) -> FloatArray:
        """Return the courses (order, segment, time, place) so long (s) after each sample.

        Beyond the ends of a recording by more than a sample they stay as they are there.
        """
        whole = round(time / self.step)
        at = self.begins[:, None] + whole + np.arange(self.samples)  # (segment, time)
        known = np.clip(at, 0, self.whole.shape[2] - 1)
        found = self.whole[:, self.rows[:, None], known]
        found[1:, at != known] = 0.0
        rest = time - whole * self.step
        return courses_after(found, np.full(self.samples, rest)) if rest else found

    def at(self, places: tuple[ForcePlace, ...]) -> FloatArray:
        """Return the courses (order, segment, time, place) at other ``places``, which hold all of its own."""
        return self.acting(places, np.ones(len(places)), np.zeros(len(places)))

    def acting(self, places: tuple[ForcePlace, ...], gain: FloatArray, delay: FloatArray) -> FloatArray:
        """Return what acts at other ``places``, (order, segment, time, place), if each is recorded with a ``gain`` and
        a ``delay`` (s): (place,), of these.
        """
        if places == self.places and not delay.any() and (gain == 1).all():
            return self.courses  # as they are
        own = [places.index(place) for place in self.places]
        found = np.zeros((ORDERS, len(self.rows), self.samples, len(places)))
        for late in np.unique(delay[own]):
            courses = self.ahead(late) if late else self.courses
            for number, position in enumerate(own):
                if delay[position] == late:
                    found[..., position] = courses[..., number] / gain[position]
        return found

    def take(self, rows: IntArray) -> "Loads":
        """Return those of some recordings or segments."""
        return replace(self, rows=self.rows[rows], begins=self.begins[rows])

    def going(self, course: Course) -> "Loads":
        """Return those of the same samples with another ``course`` between them."""
        whole = courses_of(self.whole[0], self.step, course)
        for number, place in enumerate(self.places):
            if isinstance(place, OnBase) and not place.drives:
                pushing = self.places.index(OnBase(place.along))
                for row, shown in enumerate(self.whole[:, :, 0, number].T):  # (order,) of each recording's begin
                    d, v = (shown[0], shown[1]) if place.quantity == "displacement" else (0.0, shown[0])
                    begun = float(v) / self.step, float(d) / self.step**2
                    motion = BaseMotion(place.along, self.whole[0, row, :, pushing], begun)
                    whole[:, row, :, number] = _base_courses(motion, self.step, course)[place.quantity]
        return replace(self, whole=whole)

    def times(self, factor: float) -> "Loads":
        """Return loads ``factor`` times as large."""
        return replace(self, whole=factor * self.whole)

    def finer(self, oversampling: int) -> "Loads":
        """Return those of samples ``oversampling`` times as often."""
        step = self.step / oversampling
        rest = np.tile(step * np.arange(oversampling), self.whole.shape[2])
        whole = courses_after(np.repeat(self.whole, oversampling, axis=2), rest)
        begins, samples = oversampling * self.begins, oversampling * self.samples
        return replace(self, whole=whole, begins=begins, samples=samples, step=step)

    def first(self, samples: int) -> "Loads":
        """Return those of the first ``samples``."""
        return replace(self, samples=samples)

    def cut(self, pieces: int, length: int) -> "Loads":
        """Return those of ``pieces`` segments of ``length`` samples of each recording."""
        begins = self.begins[:, None] + length * np.arange(pieces)
        return replace(self, rows=np.repeat(self.rows, pieces), begins=begins.ravel(), samples=length)


def known_places(dataset: Dataset) -> tuple[KnownPlace, ...]:
    """Return where a dataset's recordings are loaded, and what of its base's motion is felt or shown."""
    loaded = sorted({(load.node, load.direction) for r in dataset.recordings for load in r.loads})
    along = sorted({motion.along for r in dataset.recordings for motion in r.base})
    shown = {sensor.quantity for sensor in dataset.sensors if sensor.reference == "absolute"} | {"acceleration"}
    wanted = [quantity for quantity in QUANTITIES if quantity in shown]
    return (*loaded, *(OnBase(vector, quantity) for vector in along for quantity in wanted))


def loads_of(recordings: Sequence[Recording], samples: int, dataset: Dataset) -> Loads | None:
    """Return what is known to act in ``recordings`` of a dataset with as many ``samples``, None where nothing is.

    What it holds above the low-pass of the recordings is taken away, as it was from these.
    """
    rate, lowpass = dataset.sampling_rate, dataset.lowpass
    places, step = known_places(replace(dataset, recordings=tuple(recordings))), 1 / rate
    if not places:
        return None
    values = np.zeros((len(recordings), samples, len(places)))
    for number, recording in enumerate(recordings):
        for load in recording.loads:
            values[number, :, places.index((load.node, load.direction))] += behind(load.values, rate, lowpass)
    courses = courses_of(values, step, dataset.load_course)
    for number, recording in enumerate(recordings):
        for motion in recording.base:
            passed = replace(motion, values=behind(motion.values, rate, lowpass))
            for quantity, course in _base_courses(passed, step, dataset.load_course).items():
                if OnBase(motion.along, quantity) in places:
                    courses[:, number, :, places.index(OnBase(motion.along, quantity))] += course
    return Loads.of(places, courses, step)


def _base_courses(motion: BaseMotion, step: float, course: Course) -> dict[Quantity, FloatArray]:
    """Return the courses (order, time) of displacement, velocity and acceleration of a base."""
    samples = np.arange(len(motion.values))
    velocity, displacement = (integral(samples) for integral in motion.integrals(course))
    acceleration = courses_of(motion.values[None, :, None], step, course)[:, 0, :, 0]
    moving = np.vstack([step * velocity, acceleration[:-1]])
    return {
        "displacement": np.vstack([step**2 * displacement, moving[:-1]]),
        "velocity": moving,
        "acceleration": acceleration,
    }
