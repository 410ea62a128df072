"""A chain with an added mass, and its recordings with other data in them."""

from dataclasses import replace

import numpy as np

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset

CASE = blind_case(31, BlindConfig(("added_mass",), size=0.8, train=3, test=1, duration=20.0)).dataset
NAMES = [sensor.name for sensor in CASE.sensors]


def with_data(dataset: Dataset, change: dict[str, FloatArray]) -> Dataset:
    """Return the dataset with other data (realisation, time, sensor) in some recordings."""
    recordings = tuple(replace(r, data=change.get(r.name, r.data)) for r in dataset.recordings)
    return replace(dataset, recordings=recordings)


def clipped(data: FloatArray, sensor: str, share: float) -> FloatArray:
    """Return data whose channel ends at a ``share`` of its largest value."""
    column = NAMES.index(sensor)
    most = share * np.abs(data[..., column]).max()
    result = data.copy()
    result[..., column] = np.clip(result[..., column], -most, most)
    return result
