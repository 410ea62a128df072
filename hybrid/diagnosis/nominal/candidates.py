"""All causes at all places of a nominal model and of its sensors."""

import numpy as np

from fe_models.causes.candidate import Candidate
from fe_models.causes.known import Channel, Known
from fe_models.causes.places import Motion
from fe_models.causes.searched import candidates_of
from fe_models.recordings import Dataset
from hybrid.diagnosis.nominal.load_channels import load_channels
from hybrid.diagnosis.nominal.nominal_model import NominalModel


def all_candidates(
    nominal: NominalModel, dataset: Dataset, motion: Motion, measured: tuple[int, ...]
) -> tuple[Candidate, ...]:
    """Return every cause at every place that it can have; ``measured``: columns of the sensors that are fitted."""
    longest = max(recording.data.shape[-2] for recording in dataset.select("train"))  # samples
    channels = tuple(_channel(dataset, column) for column in measured)
    slowest, loads = dataset.sampling_rate / longest, load_channels(dataset, nominal)
    return candidates_of(Known(nominal, motion, channels, slowest, loads))


def _channel(dataset: Dataset, column: int) -> Channel:
    """Return what the training recordings show of a sensor, by its ``column``."""
    data = [recording.data[..., column] for recording in dataset.select("train")]
    rms = float(np.mean([part.std() for part in data]))
    duration = max(part.shape[-1] for part in data) / dataset.sampling_rate
    return Channel(dataset.sensors[column].name, rms, duration)
