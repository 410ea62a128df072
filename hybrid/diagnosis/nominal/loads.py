"""Known loads of recordings, as smooth as what a sensor samples: splines of degree seven through their values.

Loads pass the filters that recordings pass, so that they hold nothing above half the sampling rate. Straight lines from
sample to sample would take 3 % away from a force at a tenth of the sampling rate, and 26 % at three tenths; cubic
splines 0.02 % and 4 %, these nothing and 0.1 %.
"""

from dataclasses import dataclass, replace
from math import factorial

import numpy as np
from scipy.interpolate import make_interp_spline

from fe_models.arrays import FloatArray, IntArray
from fe_models.errors import raise_faults
from fe_models.measurement import lowpassed
from fe_models.recordings import Dataset, Load
from fe_models.structure import Direction
from hybrid.diagnosis.nominal.config import LOADS, LOWPASS
from hybrid.diagnosis.nominal.lowpass import beyond

ORDERS = LOADS.spline_degree + 1  # of such a spline: its value and its derivatives

LoadPlace = tuple[int, Direction]
"""Node and direction of a load."""


@dataclass(frozen=True)
class OnMode:
    """Where a force (N / sqrt(kg), as modes are mass-normalised) acts on one nominal mode alone, by its ``number``."""

    number: int


ForcePlace = LoadPlace | OnMode
"""Where a force acts whose course is given."""


@dataclass(frozen=True)
class Loads:
    """``courses`` (order, recording, time, place): the force (N, or N m) at each of the ``places``, and its derivatives
    by time (s) from each sample on.
    """

    places: tuple[ForcePlace, ...]
    courses: FloatArray

    def at(self, places: tuple[ForcePlace, ...]) -> FloatArray:
        """Return the courses (order, recording, time, place) at other ``places``, which hold all of its own."""
        found = np.zeros((*self.courses.shape[:3], len(places)))
        found[..., [places.index(place) for place in self.places]] = self.courses
        return found

    def take(self, rows: IntArray) -> "Loads":
        """Return those of some recordings or segments."""
        return replace(self, courses=self.courses[:, rows])

    def times(self, factor: float) -> "Loads":
        """Return loads ``factor`` times as large."""
        return replace(self, courses=factor * self.courses)

    def finer(self, oversampling: int, step: float) -> "Loads":
        """Return those of samples ``often`` times as often, where they were a ``step`` (s) apart."""
        rest = np.tile(step / oversampling * np.arange(oversampling), self.courses.shape[2])
        return replace(self, courses=courses_after(np.repeat(self.courses, oversampling, axis=2), rest))

    def first(self, samples: int) -> "Loads":
        """Return those of the first ``samples``."""
        return replace(self, courses=self.courses[:, :, :samples])

    def cut(self, pieces: int, length: int) -> "Loads":
        """Return those of ``pieces`` segments of ``length`` samples of each recording."""
        orders, recordings, _, places = self.courses.shape
        kept = self.courses[:, :, : pieces * length]
        return replace(self, courses=kept.reshape(orders, recordings * pieces, length, places))


def courses_of(values: FloatArray, step: float) -> FloatArray:
    """Return the courses (order, recording, time, place) of forces with ``values`` (recording, time, place) at samples
    a ``step`` (s) apart; of few samples as many orders as these determine, and zeros.
    """
    samples = np.arange(values.shape[1])
    degree = min(LOADS.spline_degree, len(samples) // 2 * 2 - 1)  # odd ones wiggle least
    spline = make_interp_spline(samples, values, degree, axis=1)
    return np.stack([spline(samples, order) / step**order for order in range(ORDERS)])


def courses_after(courses: FloatArray, rest: FloatArray) -> FloatArray:
    """Return what courses (order, recording, time, place) are a ``rest`` (time,), s, after each sample."""
    return np.stack(
        [
            sum(courses[order + more] * (rest**more / factorial(more))[:, None] for more in range(ORDERS - order))
            for order in range(ORDERS)
        ]
    )


def load_places(dataset: Dataset) -> tuple[LoadPlace, ...]:
    """Return where a dataset's recordings are loaded."""
    raise_faults(f"recording {r.name!r}: base motion is not taken yet" for r in dataset.recordings if r.base)
    return tuple(sorted({(load.node, load.direction) for r in dataset.recordings for load in r.loads}))


def loads_of(recordings: list[tuple[Load, ...]], samples: int, rate: float, lowpass: float | None) -> Loads | None:
    """Return the loads of recordings with as many ``samples`` at a ``rate`` (Hz), None where there are none.

    What a load holds above the ``lowpass`` (Hz) of the recordings is taken away, as it was from these.
    """
    places = tuple(sorted({(load.node, load.direction) for loads in recordings for load in loads}))
    if not places:
        return None
    values = np.zeros((len(recordings), samples, len(places)))
    for number, loads in enumerate(recordings):
        for load in loads:
            values[number, :, places.index((load.node, load.direction))] += behind(load.values, rate, lowpass)
    return Loads(places, courses_of(values, 1 / rate))


def behind(values: FloatArray, rate: float, lowpass: float | None) -> FloatArray:
    """Return a load's ``values`` (time,) behind the ``lowpass`` (Hz) of the recordings, which it may have passed."""
    if lowpass is None:
        return values
    power = np.abs(np.fft.rfft(values)) ** 2
    above = np.fft.rfftfreq(len(values), 1 / rate) > lowpass
    passes_by = (
        power[above].sum() > LOADS.max_share_above_lowpass * power.sum()
        or beyond(values[:, None], rate, lowpass) > LOWPASS.min_power_of_white
    )
    return lowpassed(values, rate, lowpass) if passes_by else values
