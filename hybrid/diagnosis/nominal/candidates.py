"""All causes at all places of a nominal model and of its sensors."""

import numpy as np

from fe_models.causes.candidate import Candidate, LawCandidate
from fe_models.causes.known import Channel, Known
from fe_models.causes.places import Motion
from fe_models.causes.searched import candidates_of
from fe_models.recordings import Dataset
from hybrid.diagnosis.nominal.load_channels import load_channels
from hybrid.diagnosis.nominal.nominal_model import NominalModel


def all_candidates(
    nominal: NominalModel, dataset: Dataset, motion: Motion, measured: tuple[int, ...]
) -> tuple[Candidate, ...]:
    """Return every cause at every place that it can have; ``measured``: columns of the sensors that are fitted.

    Without laws with a memory: series are marched by tables of force over elongation and rate, which hold none. The
    search by modes and motion looks for these, and is asked where series leave something open.
    """
    longest = max(recording.data.shape[-2] for recording in dataset.select("train"))  # samples
    channels = tuple(_channel(dataset, column) for column in measured)
    slowest, loads = dataset.sampling_rate / longest, load_channels(dataset, nominal)
    found = candidates_of(Known(nominal, motion, channels, slowest, loads))
    return tuple(item for item in found if not (isinstance(item, LawCandidate) and item.has_memory))


def _channel(dataset: Dataset, column: int) -> Channel:
    """Return what the training recordings show of a sensor, by its ``column``."""
    data = [recording.data[..., column] for recording in dataset.select("train")]
    rms = float(np.mean([part.std() for part in data]))
    duration = max(part.shape[-1] for part in data) / dataset.sampling_rate
    return Channel(dataset.sensors[column].name, rms, duration)
