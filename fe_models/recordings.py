"""Sensors, recordings and datasets as plain data (their file format is in `dataset_file`)."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from fe_models.arrays import BoolArray, FloatArray, IntArray
from fe_models.base_motion import Along, BaseMotion
from fe_models.directions import AnyDirection, components
from fe_models.errors import InputError
from fe_models.interpolant import Course
from fe_models.linear import LinearModel, ModalModel
from fe_models.mode_estimate import ModeEstimate
from fe_models.structure import ROTATIONS, TRANSLATIONS, Direction, Structure

SAME_RATE = 1e-6  # relative
TOLERANCE = 0.05  # of the noise floor: who states none takes forecasts that near to it for as good as it
Quantity = Literal["displacement", "velocity", "acceleration"]
Excitation = Literal["free", "measured", "ambient"]
QUANTITIES: tuple[Quantity, ...] = ("displacement", "velocity", "acceleration")  # each the rate of the one before


@dataclass(frozen=True)
class Sensor:
    """One channel: where, in which direction and what it senses; ``unit`` "1" marks a normalised channel.

    ``direction``: an axis, an angle in degrees from x towards y, or a vector, (dx, dy) or (dx, dy, dz), of any length.
    ``role``: "measured" channels are fitted, "held_out" ones only scored. ``reference``: where the base moves, sensors
    show the "absolute" motion, as accelerometers do, or that relative to the "base".
    """

    name: str
    node: int
    direction: AnyDirection
    quantity: Quantity
    unit: str
    role: Literal["measured", "held_out"] = "measured"
    reference: Literal["absolute", "base"] = "absolute"

    @property
    def components(self) -> dict[Direction, float]:
        """The part of its direction along each axis that it has one along; `InputError` where it is none."""
        return components(self.direction)

    def shown_of(self, along: Along) -> float:
        """Return what it shows of a motion by one ``along`` (dx, dy[, dz]): of a base that moves, say."""
        return sum(self.components.get(axis, 0.0) * part for axis, part in zip(TRANSLATIONS, along, strict=False))

    @property
    def turns(self) -> bool:
        """Whether it senses a rotation."""
        return self.direction in ROTATIONS


def derivative_orders(sensors: Sequence[Sensor]) -> IntArray:
    """Return how often each sensor's signal is the derivative of a displacement, (sensor,)."""
    return np.array([QUANTITIES.index(sensor.quantity) for sensor in sensors], dtype=int)


def of_each_quantity(sensors: Sequence[Sensor]) -> BoolArray:
    """Return which sensors show displacement, which velocity and which acceleration, (quantity, sensor)."""
    found = [[sensor.quantity == quantity for sensor in sensors] for quantity in QUANTITIES]
    return np.array(found, dtype=bool)


@dataclass(frozen=True, repr=False)
class Load:
    """A known force (N, or N m for "rz") at a node; ``values`` (time,), one a sample."""

    node: int
    direction: Direction
    values: FloatArray

    def __repr__(self) -> str:
        return f"Load(node {self.node} in {self.direction}, {len(self.values)} samples)"


@dataclass(frozen=True, repr=False)
class Recording:
    """``data`` (realisation, time, sensor): one recording, or many alike in one file.

    ``skipped``: samples before the first of them that were recorded and are not used. ``base``: how the supports moved.
    ``sampling_rate``: this one's own (Hz), None where it has the dataset's. ``excitation``: what moved the structure,
    as its user says: its state alone ("free"), what is known beside the data ("measured"), something unknown and
    broadband ("ambient"); None where it is left out.
    """

    name: str
    data: FloatArray
    role: Literal["train", "test"] = "train"
    loads: tuple[Load, ...] = ()
    skipped: int = 0
    base: tuple[BaseMotion, ...] = ()
    sampling_rate: float | None = None
    excitation: Excitation | None = None

    def __repr__(self) -> str:
        motions, samples, channels = self.data.shape
        many = f"{motions} motions" if motions > 1 else "1 motion"
        loads = f", {len(self.loads)} known loads" if self.loads else ""
        loads += ", base motion" if self.base else ""
        rate = f" at {self.sampling_rate:g} Hz" if self.sampling_rate is not None else ""
        moved = f", {self.excitation}" if self.excitation else ""
        return (
            f"Recording({self.name!r}: {many} of {samples} samples{rate} and {channels} channels, {self.role}"
            f"{moved}{loads})"
        )

    @property
    def is_driven(self) -> bool:
        """Whether known loads act, or the base moves in a known way."""
        return bool(self.loads or self.base)

    @property
    def driving(self) -> tuple[FloatArray, ...]:
        """The values (time,) of each known load and each base motion."""
        return (*(load.values for load in self.loads), *(motion.values for motion in self.base))

    def thinned(self, every: int) -> "Recording":
        """Return every n-th sample, of a recording that no known force drives, at no rate of its own."""
        return replace(self, data=self.data[:, ::every], skipped=self.skipped // every, sampling_rate=None)

    def part(self, begin: int, end: int | None = None, course: Course = "smooth") -> "Recording":
        """Return the samples from ``begin`` to before ``end``, of loads and base motion, too; these take a ``course``
        between samples (`Dataset.load_course`).
        """
        loads = tuple(replace(load, values=load.values[begin:end]) for load in self.loads)
        base = tuple(motion.part(begin, end, course) for motion in self.base)
        return replace(self, data=self.data[:, begin:end], loads=loads, skipped=self.skipped + begin, base=base)


@dataclass(frozen=True)
class Uncertainty:
    """Relative standard deviations that the user considers normal."""

    stiffness: float = 0.01
    mass: float = 0.01
    damping: float = 0.1


@dataclass(frozen=True)
class Assumptions:
    """What the user's own simulation assumes; None leaves the choice to the model or the program.

    ``tolerance``: by how much of the noise floor the error of forecasts may exceed it, for the user's purpose.
    """

    damping_ratio: float | tuple[float, ...] | None = None
    modes: int | None = None
    modal_model: ModalModel | None = None
    integrator: Literal["exact", "newmark"] = "exact"
    step: float | None = None
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    tolerance: float = TOLERANCE


@dataclass(frozen=True, repr=False)
class Dataset:
    """Recordings of one structure and the model they are compared with; ``sampling_rate`` and ``lowpass`` in Hz.

    ``sampling_rate`` is that of all recordings that have none of their own (`rate_of`).
    ``modes``: what somebody identified, beside recordings or alone; the ``sampling_rate`` may then be infinite, which
    stands for none. ``notes``: what a user should know of how the files were read, such as columns that were skipped.
    ``load_course``: how known loads and base motion go between their samples.
    """

    model: Structure | LinearModel
    sampling_rate: float
    sensors: tuple[Sensor, ...]
    recordings: tuple[Recording, ...]
    lowpass: float | None = None
    assumptions: Assumptions = field(default_factory=Assumptions)
    notes: tuple[str, ...] = ()
    modes: tuple[ModeEstimate, ...] = ()
    load_course: Course = "smooth"

    def __repr__(self) -> str:
        names = ", ".join(sensor.name + " (held out)" * (sensor.role == "held_out") for sensor in self.sensors)
        held = [self._recordings_in_words] if self.recordings or not self.modes else []
        if self.modes:
            states = list(dict.fromkeys(mode.recording for mode in self.modes))
            many = "modes" if len(self.modes) > 1 else "mode"
            held.append(f"{len(self.modes)} identified {many} of {', '.join(states)}")
        return f"Dataset({self.model!r}: {'; '.join(held)}; sensors {names})" + "".join(
            f"\nNote: {note}." for note in self.notes
        )

    @property
    def _recordings_in_words(self) -> str:
        motions = {role: sum(len(r.data) for r in self.select(role)) for role in ("train", "test")}
        lengths = sorted({recording.data.shape[1] / self.rate_of(recording) for recording in self.recordings})
        span = " to ".join(f"{length:.3g}" for length in dict.fromkeys(lengths[:1] + lengths[-1:]))
        rates = " and ".join(f"{rate:g}" for rate in self.sampling_rates) or f"{self.sampling_rate:g}"
        return f"{motions['train']} motions for training, {motions['test']} for testing, each {span} s at {rates} Hz"

    def rate_of(self, recording: Recording) -> float:
        """Return the sampling rate (Hz) of one of the recordings."""
        return self.sampling_rate if recording.sampling_rate is None else recording.sampling_rate

    @property
    def sampling_rates(self) -> tuple[float, ...]:
        """All sampling rates (Hz) of the recordings, each once, from the lowest."""
        return tuple(sorted({self.rate_of(recording) for recording in self.recordings}))

    def of_highest_rate(self) -> "Dataset":
        """Return the dataset with its recordings' highest rate as its own, so that only slower ones state theirs."""
        if all(recording.sampling_rate is None for recording in self.recordings):
            return self
        highest = max(self.sampling_rates)
        rates = [None if rate == highest else rate for rate in map(self.rate_of, self.recordings)]
        parts = zip(self.recordings, rates, strict=True)
        recordings = tuple(replace(recording, sampling_rate=rate) for recording, rate in parts)
        return replace(self, sampling_rate=highest, recordings=recordings)

    def of_one_rate(self, task: str) -> "Dataset":
        """Return the dataset at the lowest rate of its recordings, with that as its own.

        Of a faster recording every n-th sample is taken, which loses nothing below a stated ``lowpass``. Where
        none is stated, rates are no multiples of the lowest, or known forces act, `InputError`; ``task``: what needs
        one rate.
        """
        if len(self.sampling_rates) < 2:
            return self.of_highest_rate()
        lowest = self.sampling_rates[0]
        faster = [recording for recording in self.recordings if self.rate_of(recording) > lowest]
        multiples = all(abs(rate / lowest - round(rate / lowest)) < SAME_RATE for rate in self.sampling_rates)
        if self.lowpass is None or not multiples or any(recording.is_driven for recording in faster):
            rates = "; ".join(f"{self._named(rate)} at {rate:g} Hz" for rate in self.sampling_rates)
            raise InputError(
                f"the recordings have different sampling rates ({rates}), and {task} needs one: state the lowpass that"
                " all passed, if no forces are known and all rates are multiples of the lowest; or resample them to the"
                " lowest, or make a dataset of each rate"
            )
        parts = tuple(each.thinned(round(self.rate_of(each) / lowest)) for each in self.recordings)
        return replace(self, sampling_rate=lowest, recordings=parts)

    def _named(self, sampling_rate: float) -> str:
        return ", ".join(recording.name for recording in self.recordings if self.rate_of(recording) == sampling_rate)

    @property
    def is_loaded(self) -> bool:
        """Whether known loads act, or the base moves in a known way, in any recording."""
        return any(recording.is_driven for recording in self.recordings)

    def parted(self) -> "tuple[Dataset | None, Dataset | None]":
        """Return the dataset with its driven recordings alone, and with the others; None where there are none."""
        driven, free = (tuple(r for r in self.recordings if r.is_driven is side) for side in (True, False))
        return (
            replace(self, recordings=driven) if driven else None,
            replace(self, recordings=free) if free or not driven else None,
        )

    def require_recordings(self, task: str) -> None:
        """Raise an `InputError` where there are identified modes alone; ``task``: what needs time series."""
        if self.modes and not self.recordings:
            raise InputError(
                f"the dataset has identified modes alone, which {task} does not take yet: give it [[recordings]], too"
            )

    def select(self, role: Literal["train", "test"]) -> tuple[Recording, ...]:
        """Return the recordings of one role, in order."""
        return tuple(recording for recording in self.recordings if recording.role == role)

    def split(self, share: float) -> "Dataset":
        """Return the dataset with the first ``share`` of its motions for training and the others for testing.

        At least one of each; a recording of many motions is cut where the share ends. `InputError` where there is one
        motion alone.
        """
        motions = sum(len(recording.data) for recording in self.recordings)
        if motions < 2 or not 0 < share < 1:
            raise InputError(f"{motions} motions cannot be split at {share:g}: give two or more, and a share in (0, 1)")
        left = min(max(1, round(share * motions)), motions - 1)
        parts = list[Recording]()
        for recording in self.recordings:
            train, test = recording.data[:left], recording.data[left:]
            left -= len(train)
            name = f"{recording.name}_test" if len(train) and len(test) else recording.name
            parts += [replace(recording, data=train, role="train")] * bool(len(train))
            parts += [replace(recording, name=name, data=test, role="test")] * bool(len(test))
        roles = {recording.name: recording.role for recording in parts}
        modes = tuple(replace(mode, role=roles.get(mode.recording, mode.role)) for mode in self.modes)
        return replace(self, recordings=tuple(parts), modes=modes)

    def with_model(self, model: Structure | LinearModel) -> "Dataset":
        """Return the same recordings to be held against another ``model``."""
        return replace(self, model=model)
