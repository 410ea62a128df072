"""Which of the known loads one instrument recorded, and share its faults."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.base_motion import base_force
from fe_models.causes.known import LoadChannel
from fe_models.causes.load_name import LoadName
from fe_models.recordings import Dataset
from hybrid.diagnosis.nominal.loads import OnBase
from hybrid.diagnosis.nominal.nominal_model import NominalModel

PROPORTIONAL = 1e-9  # of their size: how far two loads are from being one times a number, but for rounding
AXES = ((1.0, 0.0), (0.0, 1.0))


def load_channels(dataset: Dataset, nominal: NominalModel) -> tuple[LoadChannel, ...]:
    """Return what each instrument recorded, and, of several, all of it together, as one clock may have recorded it.

    Loads that are proportional to each other in all recordings are one channel; those that pull at each mass as a
    moving base does, too. The base's motion is one channel, whatever its directions.
    """
    on_base = tuple(number for number, place in enumerate(nominal.loaded) if isinstance(place, OnBase))
    found = [LoadChannel("base", on_base)] if on_base else []
    values = _values(dataset, nominal)
    left = [number for number in range(len(nominal.loaded)) if number not in on_base]
    while left:
        group = [number for number in left if _is_proportional(values[left[0]], values[number])]
        left = [number for number in left if number not in group]
        names: list[LoadName] = [place for n in group if not isinstance(place := nominal.loaded[n], OnBase)]
        if len(group) > 1 and _pulls_as_base(group, values, nominal):
            found.append(LoadChannel("base", tuple(group)))
        else:
            found.append(LoadChannel(names[0], tuple(group), tuple(names[1:])))
    if len(found) > 1:
        found.append(LoadChannel("all", tuple(range(len(nominal.loaded)))))
    return tuple(found)


def _values(dataset: Dataset, nominal: NominalModel) -> FloatArray:
    """Return the values of the loads at each of the known places in all recordings, one behind the other."""
    lengths = [recording.data.shape[1] for recording in dataset.recordings]
    values = np.zeros((len(nominal.loaded), sum(lengths)))
    for recording, begin in zip(dataset.recordings, np.cumsum([0, *lengths]), strict=False):
        for load in recording.loads:
            own = values[nominal.loaded.index((load.node, load.direction))]
            own[begin : begin + len(load.values)] += load.values
    return values


def _is_proportional(one: FloatArray, other: FloatArray) -> bool:
    """Return whether the ``other`` course is a number times ``one``."""
    size = float(one @ one)
    left = other - (float(one @ other) / size if size else 0.0) * one
    return bool(np.linalg.norm(left) <= PROPORTIONAL * np.linalg.norm(other))


def _pulls_as_base(group: list[int], values: FloatArray, nominal: NominalModel) -> bool:
    """Return whether the loads of a ``group``, proportional to each other, pull at all masses as a moving base does."""
    amounts = values[group] @ values[group[0]]
    pull = np.where(nominal.dofs.free, amounts @ nominal.load_pulls[group], 0.0)
    inertia = (np.where(nominal.dofs.free, base_force(nominal.mass, nominal.dofs, along), 0.0) for along in AXES)
    return any(force.any() and _is_proportional(force, pull) for force in inertia)
