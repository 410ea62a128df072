"""The recordings of a dataset beside one another and beside the nominal model's modes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.errors import InputError, raise_faults
from fe_models.modes import mac, natural_modes
from fe_models.progress import nothing
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.identification.agreement import shares_unexplained, window_of
from hybrid.identification.backbone import Backbone, backbone_of
from hybrid.identification.combinations import Combination, combinations_of
from hybrid.identification.config import COMPARISON
from hybrid.identification.free_decay_modes import identify_modes
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.pairing import displacements_of, paired

NOTHING_IN_COMMON = (
    "none of the model's modes is seen in all recordings, no more in {name!r}: these are too short (ten periods are"
    " enough), or their modes too unlike the model's; nothing can be compared"
)


@dataclass(frozen=True)
class Observed:
    """One recording of so many s (``lasts``): its ``identified`` modes, their ``shapes`` (sensor, identified) of
    displacements; ``criterion`` (mode, identified), their MAC with the nominal modes at the sensors; ``chosen`` (mode,)
    which is each nominal mode, -1 where none is; ``backbones`` of the followed modes; ``combinations`` of their
    frequencies.
    """

    name: str
    lasts: float
    identified: IdentifiedModes
    shapes: FloatArray
    criterion: FloatArray
    chosen: tuple[int, ...]
    backbones: tuple[Backbone, ...]
    combinations: tuple[Combination, ...]

    @property
    def shown(self) -> list[int]:
        """Numbers of the identified modes of which the recording holds enough periods to tell something of them."""
        return [int(n) for n in np.flatnonzero(self.identified.frequencies * self.lasts >= COMPARISON.min_periods)]


@dataclass(frozen=True)
class Compared:
    """``nominal`` frequencies (mode,) Hz and ``shapes`` (sensor, mode), of displacements, of the model; ``sensors``:
    their names; ``followed``: numbers (from 0) of the strongest modes, by frequency; ``recordings``, and the share that
    each one's modes leave of the others, ``left`` (model, recording), in windows of ``window`` s.
    """

    nominal: FloatArray
    shapes: FloatArray
    sensors: tuple[str, ...]
    followed: tuple[int, ...]
    recordings: tuple[Observed, ...]
    left: FloatArray
    window: float


def compare_recordings(dataset: Dataset, advance: Callable[[], object] = nothing) -> Compared:
    """Return the comparison; `InputError` where the model is no structure, or no strong mode is one of its own.

    ``advance`` is called after each motion's modes have been identified, which takes seconds. The shortest motions
    come first: what cannot be compared is told as soon as it shows.
    """
    dataset.require_recordings("a comparison of recordings")
    dataset = dataset.of_one_rate("a comparison of recordings")
    rate, highest = dataset.sampling_rate, min(dataset.lowpass or np.inf, dataset.sampling_rate / 2)
    nominal, shapes = _nominal(dataset, highest)
    raise_faults(_too_short(dataset, float(nominal[-1])))
    singles = [(recording.name, data) for recording in dataset.recordings for data in recording.data]
    count = min(COMPARISON.max_modes, len(nominal) + COMPARISON.extra_modes)
    found_in: dict[int, tuple[IdentifiedModes, FloatArray, FloatArray, tuple[int, ...]]] = {}
    seen = set(range(len(nominal)))
    for number in sorted(range(len(singles)), key=lambda number: len(singles[number][1])):
        lasts = len(singles[number][1]) / rate
        own = identify_modes(singles[number][1], rate, float(nominal[0]), highest, count)
        moved = displacements_of(own.real_shapes, own.frequencies, dataset.sensors)
        criterion = mac(shapes, moved)
        picked = paired(nominal, own.frequencies, own.energy, criterion, len(moved), lasts)
        found_in[number] = own, moved, criterion, picked
        seen &= {mode for mode in seen if picked[mode] >= 0}
        if not seen:
            raise InputError(NOTHING_IN_COMMON.format(name=singles[number][0]))
        advance()
    in_order = [found_in[number] for number in range(len(singles))]
    identified = [own for own, *_ in in_order]
    followed = _strongest(seen, [picked for *_, picked in in_order], identified)
    found = [
        Observed(
            name,
            len(data) / rate,
            own,
            moved,
            criterion,
            picked,
            tuple(backbone_of(data, own, picked[mode], rate) for mode in followed),
            tuple(_combinations(data, rate, own, picked, followed, highest)),
        )
        for (name, data), (own, moved, criterion, picked) in zip(singles, in_order, strict=True)
    ]
    motions = [data for _, data in singles]
    samples = window_of(identified, motions, rate)
    left = shares_unexplained(identified, motions, rate, samples)
    names = tuple(sensor.name for sensor in dataset.sensors)
    return Compared(nominal, shapes, names, followed, tuple(found), left, samples / rate)


def _combinations(
    data: FloatArray, rate: float, own: IdentifiedModes, picked: tuple[int, ...], followed: tuple[int, ...], top: float
) -> list[Combination]:
    """Return the combinations of the modes ``followed`` up to ``top`` Hz, beside all modes that are the model's."""
    known = {mode: number for mode, number in enumerate(picked) if number >= 0}
    natural = {mode: (float(own.frequencies[n]), float(own.ratios[n])) for mode, n in known.items()}
    return combinations_of(data, rate, [natural[mode][0] for mode in followed], top, natural)


def _nominal(dataset: Dataset, highest: float) -> tuple[FloatArray, FloatArray]:
    """Return the model's frequencies (mode,) up to ``highest`` Hz and shapes (sensor, mode)."""
    if not isinstance(dataset.model, Structure):
        raise InputError("model: bare matrices do not say where sensors sit: give a structure file")
    model = linearise(dataset.model)
    rows = [model.dofs.row(sensor.node, sensor.direction) for sensor in dataset.sensors]
    modal = natural_modes(model, min(len(rows) + 2, len(model.dofs.free_rows)))
    kept = modal.frequencies <= highest
    if not kept.any():
        raise InputError(f"model: all its natural frequencies are above {highest:g} Hz, up to where recordings go")
    return modal.frequencies[kept], modal.shapes[rows][:, kept]


def _too_short(dataset: Dataset, fastest: float) -> list[str]:
    """Return a fault for each recording that holds too little even of the ``fastest`` (Hz) of the model's modes."""
    least = COMPARISON.min_periods / fastest
    lengths = [(each.name, each.data.shape[1] / dataset.sampling_rate) for each in dataset.recordings]
    return [
        f"recording {name!r} lasts {length:.3g} s: give {least:.3g} s or more, {COMPARISON.min_periods:g} periods of"
        " the fastest mode; ten of the lowest are enough for all"
        for name, length in lengths
        if length < least
    ]


def _strongest(
    seen: set[int], chosen: Sequence[tuple[int, ...]], identified: Sequence[IdentifiedModes]
) -> tuple[int, ...]:
    """Return the one or two of the modes ``seen`` in all recordings that hold most energy."""
    every = list(zip(identified, chosen, strict=True))
    held = {mode: sum(own.energy[picked[mode]] for own, picked in every) for mode in seen}
    return tuple(sorted(sorted(seen, key=lambda mode: -held[mode])[: COMPARISON.backbone_modes]))
