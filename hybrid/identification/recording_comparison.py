"""The recordings of a dataset beside one another and beside the nominal model's modes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.errors import InputError
from fe_models.modes import mac, natural_modes
from fe_models.progress import nothing
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.identification.agreement import shares_unexplained, window_of
from hybrid.identification.backbone import Backbone, backbone_of
from hybrid.identification.combinations import Combination, combinations_of
from hybrid.identification.config import COMPARISON
from hybrid.identification.free_decay_modes import IdentifiedModes, identify_modes


@dataclass(frozen=True)
class Observed:
    """One recording: its ``identified`` modes; ``criterion`` (mode, identified), their MAC with the nominal modes at
    the sensors; ``chosen`` (mode,) which is each nominal mode, -1 where none is; ``backbones`` of the followed modes;
    ``combinations`` of their frequencies.
    """

    name: str
    identified: IdentifiedModes
    criterion: FloatArray
    chosen: tuple[int, ...]
    backbones: tuple[Backbone, ...]
    combinations: tuple[Combination, ...]


@dataclass(frozen=True)
class Compared:
    """``nominal`` frequencies (mode,) Hz and ``shapes`` (sensor, mode) of the model; ``sensors``: their names;
    ``followed``: numbers (from 0) of the strongest modes, by frequency; ``recordings``, and the share that each one's
    modes leave of the others, ``left`` (model, recording), in windows of ``window`` s.
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

    ``advance`` is called after each motion's modes have been identified, which takes seconds.
    """
    if not isinstance(dataset.model, Structure):
        raise InputError("model: bare matrices do not say where sensors sit: give a structure file")
    rate = dataset.sampling_rate
    highest = min(dataset.lowpass or np.inf, rate / 2)
    model = linearise(dataset.model)
    rows = [model.dofs.row(sensor.node, sensor.direction) for sensor in dataset.sensors]
    modal = natural_modes(model, min(len(rows) + 2, len(model.dofs.free_rows)))
    kept = modal.frequencies <= highest
    nominal, shapes = modal.frequencies[kept], modal.shapes[rows][:, kept]
    singles = [(recording.name, data) for recording in dataset.recordings for data in recording.data]
    if not len(nominal):
        raise InputError(f"model: all its natural frequencies are above {highest:g} Hz, up to where recordings go")
    identified, count = list[IdentifiedModes](), min(COMPARISON.max_modes, len(nominal) + COMPARISON.extra_modes)
    for _, data in singles:
        identified.append(identify_modes(data, rate, float(nominal[0]), highest, count))
        advance()
    criteria = [mac(shapes, own.shapes) for own in identified]
    chosen = [_chosen(nominal, own, criterion) for own, criterion in zip(identified, criteria, strict=True)]
    followed = _strongest(chosen, identified)
    found = [
        Observed(
            name,
            own,
            criterion,
            picked,
            tuple(backbone_of(data, own, picked[mode], rate) for mode in followed),
            tuple(combinations_of(data, rate, [own.frequencies[picked[mode]] for mode in followed], highest)),
        )
        for (name, data), own, criterion, picked in zip(singles, identified, criteria, chosen, strict=True)
    ]
    motions = [data for _, data in singles]
    samples = window_of(identified, motions, rate)
    left = shares_unexplained(identified, motions, rate, samples)
    names = tuple(sensor.name for sensor in dataset.sensors)
    return Compared(nominal, shapes, names, followed, tuple(found), left, samples / rate)


def _chosen(nominal: FloatArray, own: IdentifiedModes, criterion: FloatArray) -> tuple[int, ...]:
    """Return the strongest identified mode of each nominal one's shape and about its frequency, each for one only."""
    near = np.abs(own.frequencies / nominal[:, None] - 1) <= COMPARISON.max_frequency_difference
    fits = np.where(near & (criterion >= COMPARISON.min_mac), criterion, 0.0)
    order = np.lexsort((np.abs(own.frequencies / nominal[:, None] - 1), -fits.round(2)), axis=0)
    best = order[0]  # nominal mode of each
    energy = np.where((fits > 0) & (best == np.arange(len(nominal))[:, None]), own.energy, 0.0)
    return tuple(int(np.argmax(row)) if row.any() else -1 for row in energy)


def _strongest(chosen: list[tuple[int, ...]], identified: list[IdentifiedModes]) -> tuple[int, ...]:
    """Return the one or two modes that all recordings have and that hold most energy."""
    everywhere = [mode for mode in range(len(chosen[0])) if all(picked[mode] >= 0 for picked in chosen)]
    if not everywhere:
        raise InputError(
            "none of the model's modes is seen in all recordings: these are too short (ten periods are enough), or"
            " their modes too unlike the model's; nothing can be compared"
        )
    every = list(zip(identified, chosen, strict=True))
    held = {mode: sum(own.energy[picked[mode]] for own, picked in every) for mode in everywhere}
    return tuple(sorted(sorted(everywhere, key=lambda mode: -held[mode])[: COMPARISON.backbone_modes]))
