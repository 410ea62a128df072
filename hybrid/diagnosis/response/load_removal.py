"""Recordings less what known loads make the nominal structure do: free motion and noise, nearly."""

from dataclasses import replace

import numpy as np

from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.loaded import loaded_channels
from hybrid.diagnosis.response.state_space import system_of


def without_load_response(
    nominal: NominalModel, batches: tuple[Batch, ...], outputs: SensorOutputs
) -> tuple[Batch, ...]:
    """Return the batches without the response to their loads from rest, but with the loads; force laws are left out."""
    if not nominal.loaded:
        return batches
    linear = Hypothesis(replace(nominal, laws=()))
    system = system_of(linear, np.zeros((1, linear.nuisances)), outputs)
    return tuple(
        batch if batch.loads is None else batch.less(loaded_channels(system, batch.loads)[0]) for batch in batches
    )
