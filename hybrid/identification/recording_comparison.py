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
    """One recording: its ``lines``; ``criterion`` (mode, line), their MAC with the nominal modes at the sensors;
    ``chosen`` (mode,) the line of each mode, -1 where there is none; ``backbones`` of the followed modes;
    ``combinations`` of their frequencies.
    """

    name: str
    lines: IdentifiedModes
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
    """Return the comparison; `InputError` where the model is no structure, or no strong line is one of its modes.

    ``advance`` is called after each motion's lines have been found, which takes seconds.
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
    lines, count = list[IdentifiedModes](), min(COMPARISON.max_modes, len(nominal) + COMPARISON.extra_modes)
    for _, data in singles:
        lines.append(identify_modes(data, rate, float(nominal[0]), highest, count))
        advance()
    criteria = [mac(shapes, own.shapes) for own in lines]
    chosen = [_chosen(nominal, own, criterion) for own, criterion in zip(lines, criteria, strict=True)]
    followed = _strongest(chosen, lines)
    found = [
        Observed(
            name,
            own,
            criterion,
            line,
            tuple(backbone_of(data, own, line[mode], rate) for mode in followed),
            tuple(combinations_of(data, rate, [own.frequencies[line[mode]] for mode in followed], highest)),
        )
        for (name, data), own, criterion, line in zip(singles, lines, criteria, chosen, strict=True)
    ]
    motions = [data for _, data in singles]
    samples = window_of(lines, motions, rate)
    left = shares_unexplained(lines, motions, rate, samples)
    names = tuple(sensor.name for sensor in dataset.sensors)
    return Compared(nominal, shapes, names, followed, tuple(found), left, samples / rate)


def _chosen(nominal: FloatArray, own: IdentifiedModes, criterion: FloatArray) -> tuple[int, ...]:
    """Return the strongest line of each mode's shape and about its frequency, each line for the mode it fits best."""
    near = np.abs(own.frequencies / nominal[:, None] - 1) <= COMPARISON.max_frequency_difference
    fits = np.where(near & (criterion >= COMPARISON.min_mac), criterion, 0.0)
    best = np.lexsort((np.abs(own.frequencies / nominal[:, None] - 1), -fits.round(2)), axis=0)[0]  # mode of each line
    energy = np.where((fits > 0) & (best == np.arange(len(nominal))[:, None]), own.energy, 0.0)
    return tuple(int(np.argmax(row)) if row.any() else -1 for row in energy)


def _strongest(chosen: list[tuple[int, ...]], lines: list[IdentifiedModes]) -> tuple[int, ...]:
    """Return the one or two modes that all recordings have and that hold most energy."""
    everywhere = [mode for mode in range(len(chosen[0])) if all(line[mode] >= 0 for line in chosen)]
    if not everywhere:
        raise InputError(
            "none of the model's modes is seen in all recordings: these are too short (ten periods are enough), or"
            " their modes too unlike the model's; nothing can be compared"
        )
    held = {mode: sum(own.energy[line[mode]] for own, line in zip(lines, chosen, strict=True)) for mode in everywhere}
    return tuple(sorted(sorted(everywhere, key=lambda mode: -held[mode])[: COMPARISON.backbone_modes]))
