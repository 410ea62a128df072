"""The recordings of a dataset beside one another and beside the nominal model's modes."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.errors import InputError, raise_faults
from fe_models.linear import LinearModel
from fe_models.mode_count import mode_count
from fe_models.modes import mac, natural_modes
from fe_models.progress import nothing
from fe_models.recordings import Dataset, Recording, derivative_orders
from fe_models.sensing import seen
from hybrid.identification.agreement import shares_unexplained, window_of
from hybrid.identification.backbone import Backbone, backbone_of
from hybrid.identification.combinations import Combination, combinations_of, sums_of_stronger
from hybrid.identification.config import COMPARISON
from hybrid.identification.harmonics import Harmonic
from hybrid.identification.identification import Identification, identify
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.mode_changes import RecordingChange, changes_among
from hybrid.identification.pairing import displacements_of, paired
from hybrid.identification.shape_correlation import coordinate_mac
from hybrid.identification.suspect_sensors import MODELS, suspect_sensors

LISTED = 6  # modes in a message

NOTHING_IN_COMMON = (
    "none of the model's modes is seen in all recordings, no more in {name!r}, which shows {shown}, where the model has"
    " {expected}: these are too short (ten periods are enough), or their modes too unlike the model's; nothing can be"
    " compared"
)


@dataclass(frozen=True)
class Observed:
    """One recording of so many s (``lasts``): what was ``found`` in it; ``shapes`` (sensor, identified), of
    displacements, of its modes; ``criterion`` (mode, identified), their MAC with the nominal modes at the sensors;
    ``chosen`` (mode,), which is each nominal mode, -1 where none is. Of a free decay, ``backbones`` of the followed
    modes and ``combinations`` of their frequencies.
    """

    name: str
    lasts: float
    found: Identification
    shapes: FloatArray
    criterion: FloatArray
    chosen: tuple[int, ...]
    backbones: tuple[Backbone, ...]
    combinations: tuple[Combination, ...]

    @property
    def identified(self) -> IdentifiedModes:
        """The modes of the recording."""
        return self.found.modes

    @property
    def shown(self) -> list[int]:
        """Numbers of the identified modes of which the recording holds enough periods to tell something of them."""
        return [int(n) for n in np.flatnonzero(self.identified.frequencies * self.lasts >= COMPARISON.min_periods)]

    def loudest(self, mode: int) -> int:
        """Return the number of the sensor whose signal, in its own unit, one of the model's modes has most of."""
        return int(np.argmax(np.abs(self.identified.real_shapes[:, self.chosen[mode]])))

    def largest(self, line: Harmonic) -> int:
        """Return the number of the sensor at which a machine's ``line`` moves the structure most."""
        return int(np.argmax(line.amplitude / (2 * np.pi * line.frequency) ** self.identified.orders))


@dataclass(frozen=True)
class Compared:
    """``nominal`` frequencies (mode,) Hz and ``shapes`` (sensor, mode), of displacements, of the model; ``sensors``:
    their names; ``followed``: numbers (from 0) of the strongest modes, by frequency; ``recordings``, and the share that
    each one's modes leave of the others, ``left`` (model, recording), in windows of ``window`` s, NaN of those that are
    no free decays; ``changes`` between each two recordings, or each and the first of each state of many.
    """

    nominal: FloatArray
    shapes: FloatArray
    sensors: tuple[str, ...]
    followed: tuple[int, ...]
    recordings: tuple[Observed, ...]
    left: FloatArray
    window: float
    changes: tuple[RecordingChange, ...] = ()

    @property
    def has_ambient(self) -> bool:
        """Whether any of the recordings is one of ambient vibration."""
        return any(observed.found.is_ambient for observed in self.recordings)

    def pairs(self, observed: Observed) -> list[tuple[int, int]]:
        """Return the numbers of the nominal modes that a recording shows, and of the identified ones that they are."""
        return [(mode, own) for mode, own in enumerate(observed.chosen) if own >= 0]

    def coordinate_mac(self, observed: Observed) -> FloatArray:
        """Return the coordinate MAC (sensor,) of a recording's shapes with the nominal ones."""
        numbers = np.array(self.pairs(observed), dtype=int).reshape(-1, 2)
        return coordinate_mac(self.shapes[:, numbers[:, 0]], observed.shapes[:, numbers[:, 1]])

    def suspects(self) -> list[str]:
        """Return a line for each recording with a sensor that keeps shapes from being the model's."""
        lines = []
        for own in self.recordings:
            modes = own.identified
            found = suspect_sensors(self.nominal, self.shapes, modes.frequencies, modes.displacements)
            if found is not None and any(own.chosen[mode] < 0 for mode in found.modes):
                lines.append(f"{own.name}: {found.words(self.sensors, MODELS)}")
        return lines


def compare_recordings(
    dataset: Dataset, advance: Callable[[], object] = nothing, known: Mapping[str, Identification] | None = None
) -> Compared:
    """Return the comparison; `InputError` where no strong mode is one of the model's.

    ``advance`` is called after each motion's modes have been identified, which takes seconds. The shortest motions
    come first: what cannot be compared is told as soon as it shows. ``known``: what was identified before, with all
    sensors, by the names of recordings of one motion.
    """
    dataset.require_recordings("a comparison of recordings")
    highest = max(_highest(dataset, recording) for recording in dataset.recordings)
    nominal, shapes = _nominal(dataset, highest)
    raise_faults(_too_short(dataset, float(nominal[-1])))
    singles = [(recording, data) for recording in dataset.recordings for data in recording.data]
    count = min(COMPARISON.max_modes, len(nominal) + COMPARISON.extra_modes)
    found_in: dict[int, Observed] = {}
    seen = set(range(len(nominal)))
    for number in sorted(range(len(singles)), key=lambda number: len(singles[number][1])):
        observed = _observed(dataset, *singles[number], (nominal, shapes), count, known or {})
        found_in[number] = observed
        seen &= {mode for mode in seen if observed.chosen[mode] >= 0}
        if not seen:
            raise InputError(_nothing_in_common(dataset, observed, nominal, shapes))
        advance()
    observations = [found_in[number] for number in range(len(singles))]
    followed = _strongest(seen, observations)
    free = [number for number, observed in enumerate(observations) if not observed.found.is_ambient]
    for number in free:
        recording, data = singles[number]
        observations[number] = _with_decay(dataset, recording, data, observations[number], followed)
    left, window = _left(dataset, [singles[number] for number in free], [observations[n] for n in free])
    every = np.full((len(singles), len(singles)), np.nan)
    every[np.ix_(free, free)] = left
    changes = changes_among(
        [own.identified for own in observations],
        [own.shapes for own in observations],
        [own.chosen for own in observations],
    )
    names = tuple(sensor.name for sensor in dataset.sensors)
    return Compared(nominal, shapes, names, followed, tuple(observations), every, window, changes)


def _nothing_in_common(dataset: Dataset, observed: Observed, nominal: FloatArray, shapes: FloatArray) -> list[str]:
    """Return why the modes of a recording are not the model's, as far as they tell."""
    own = observed.identified.strongest(LISTED)
    shown = f"{_listed(own.frequencies)} Hz" if len(own.frequencies) else "no mode at all"
    faults = [NOTHING_IN_COMMON.format(name=observed.name, shown=shown, expected=f"{_listed(nominal[:LISTED])} Hz")]
    suspect = suspect_sensors(nominal, shapes, observed.identified.frequencies, observed.identified.displacements)
    if suspect is not None:
        faults.append(f"{observed.name}: {suspect.words([sensor.name for sensor in dataset.sensors], MODELS)}")
    return faults


def _listed(frequencies: FloatArray) -> str:
    return ", ".join(f"{frequency:.4g}" for frequency in frequencies)


def _highest(dataset: Dataset, recording: Recording) -> float:
    """Return the frequency (Hz) up to which a recording goes."""
    return min(dataset.lowpass or np.inf, dataset.rate_of(recording) / 2)


def _observed(
    dataset: Dataset,
    recording: Recording,
    data: FloatArray,
    model: tuple[FloatArray, FloatArray],
    count: int,
    known: Mapping[str, Identification],
) -> Observed:
    """Return what a motion (time, sensor) shows beside the ``model``'s frequencies and shapes."""
    nominal, rate = model[0], dataset.rate_of(recording)
    found = known.get(recording.name)
    if found is None or len(found.modes.shapes) != len(dataset.sensors):
        moved_by = "measured" if recording.is_driven else recording.excitation
        found = identify(
            [data],
            rate,
            float(nominal[0]),
            _highest(dataset, recording),
            derivative_orders(dataset.sensors),
            moved_by,
        )
    found = replace(found, modes=found.modes.strongest(count))
    return _paired(recording.name, found, len(data) / rate, model)


def _paired(
    name: str,
    found: Identification,
    lasts: float,
    model: tuple[FloatArray, FloatArray],
) -> Observed:
    """Return what was ``found`` in a recording beside the ``model``'s frequencies and shapes."""
    (nominal, shapes), own = model, found.modes
    moved = displacements_of(own)
    criterion = mac(shapes, moved)
    picked = paired(nominal, own.frequencies, own.energy, criterion, len(moved), lasts, sums_of_stronger(own))
    return Observed(name, lasts, found, moved, criterion, picked, (), ())


def beside(compared: Compared, dataset: Dataset) -> Compared:
    """Return what was seen in recordings beside the model that the ``dataset`` has now, another one.

    Backbones and combinations are of the modes that were followed first, and are left out.
    """
    highest = max(_highest(dataset, recording) for recording in dataset.recordings)
    model = _nominal(dataset, highest)
    recordings = tuple(_paired(own.name, own.found, own.lasts, model) for own in compared.recordings)
    return replace(compared, nominal=model[0], shapes=model[1], followed=(), recordings=recordings)


def _with_decay(
    dataset: Dataset, recording: Recording, data: FloatArray, observed: Observed, followed: tuple[int, ...]
) -> Observed:
    """Return what a free decay shows besides: backbones and combinations of the modes ``followed``."""
    rate, own, picked = dataset.rate_of(recording), observed.identified, observed.chosen
    backbones = tuple(backbone_of(data, own, picked[mode], rate) for mode in followed)
    combinations = _combinations(data, rate, own, picked, followed, _highest(dataset, recording))
    return replace(observed, backbones=backbones, combinations=tuple(combinations))


def _left(
    dataset: Dataset, singles: Sequence[tuple[Recording, FloatArray]], observations: Sequence[Observed]
) -> tuple[FloatArray, float]:
    """Return the shares that the modes of free decays leave of each other, and the windows (s) for it."""
    if not singles:
        return np.zeros((0, 0)), 0.0
    models, motions = [own.identified for own in observations], [data for _, data in singles]
    window = window_of(models, [own.lasts for own in observations])
    return shares_unexplained(models, motions, [dataset.rate_of(recording) for recording, _ in singles], window), window


def _combinations(
    data: FloatArray, rate: float, own: IdentifiedModes, picked: tuple[int, ...], followed: tuple[int, ...], top: float
) -> list[Combination]:
    """Return the combinations of the modes ``followed`` up to ``top`` Hz, beside all modes that are the model's."""
    known = {mode: number for mode, number in enumerate(picked) if number >= 0}
    natural = {mode: (float(own.frequencies[n]), float(own.ratios[n])) for mode, n in known.items()}
    return combinations_of(data / own.sizes, rate, [natural[mode][0] for mode in followed], top, natural)


def _nominal(dataset: Dataset, highest: float) -> tuple[FloatArray, FloatArray]:
    """Return the model's frequencies (mode,) up to ``highest`` Hz and shapes (sensor, mode)."""
    model = dataset.model if isinstance(dataset.model, LinearModel) else linearise(dataset.model)
    picked = seen(model.dofs, dataset.sensors)
    modal = natural_modes(model, min(len(picked) + 2, mode_count(model)))
    kept = modal.frequencies <= highest
    if not kept.any():
        raise InputError(f"model: all its natural frequencies are above {highest:g} Hz, up to where recordings go")
    return modal.frequencies[kept], picked @ modal.shapes[:, kept]


def _too_short(dataset: Dataset, fastest: float) -> list[str]:
    """Return a fault for each recording that holds too little even of the ``fastest`` (Hz) of the model's modes."""
    least = COMPARISON.min_periods / fastest
    lengths = [(each.name, each.data.shape[1] / dataset.rate_of(each)) for each in dataset.recordings]
    return [
        f"recording {name!r} lasts {length:.3g} s: give {least:.3g} s or more, {COMPARISON.min_periods:g} periods of"
        " the fastest mode; ten of the lowest are enough for all"
        for name, length in lengths
        if length < least
    ]


def _strongest(seen: set[int], observations: Sequence[Observed]) -> tuple[int, ...]:
    """Return the one or two of the modes ``seen`` in all recordings that hold most energy."""
    held = {mode: sum(own.identified.energy[own.chosen[mode]] for own in observations) for mode in seen}
    return tuple(sorted(sorted(seen, key=lambda mode: -held[mode])[: COMPARISON.backbone_modes]))
