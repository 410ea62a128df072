"""From a dataset to experts ready to train: `prepare` for each training recording that agrees with the others."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.nominal import nominal_modes
from fe_models.progress import nothing
from fe_models.recordings import Dataset, Recording
from hybrid.config import Config
from hybrid.estimation.experts import NO_KNOWN_FORCES, Experts
from hybrid.estimation.linear_calibration import Observer
from hybrid.estimation.start_evidence import StartEvidence, evidence_of
from hybrid.estimation.windows import columns, cut, evenly, window_length
from hybrid.training.config import PREPARATION
from hybrid.training.preparation import Prepared, agreeing_recordings, prepare, training_recordings
from hybrid.training.trainable import trainable


def prepare_experts(dataset: Dataset, config: Config, advance: Callable[[], object] = nothing) -> Prepared[Experts]:
    """Return an expert for each training recording that one structure can have made; `InputError` where none can be."""
    if config.model.encoder != "window" or config.model.residual == "places" or not config.training.calibrate:
        raise InputError("experts need an encoder that reads windows, and a calibrated start: see --preset experts")
    dataset = trainable(dataset)
    if dataset.is_loaded:
        raise InputError(NO_KNOWN_FORCES)
    recordings, measured = training_recordings(dataset), columns(dataset, "measured")
    length = window_length(dataset, config)
    modal = nominal_modes(dataset, config.model.modes)
    observer = Observer(modal, [dataset.sensors[i] for i in measured], 1 / dataset.sampling_rate)
    kept = agreeing_recordings(observer, recordings, measured, length, advance)
    own = replace(config, training=replace(config.training, window=length))
    parts = [prepare(replace(dataset, recordings=(recording,)), own, advance) for recording in kept]
    evidence = [start_evidence(recording, measured, config.model.encoder_samples) for recording in kept]
    names = tuple(recording.name for recording in kept)
    return Prepared(
        model=Experts([part.model for part in parts], evidence, [len(part.windows) for part in parts]),
        modal=modal,
        windows=np.concatenate([part.windows for part in parts]),
        kept=names,
        left_out=tuple(recording.name for recording in recordings if recording.name not in names),
        unexplained=float(np.mean([part.unexplained or 0.0 for part in parts])),
    )


def start_evidence(recording: Recording, measured: list[int], samples: int) -> StartEvidence:
    """Return the evidence for a recording: every sample but the last ones begins a start."""
    starts: FloatArray = cut(replace(recording, data=recording.data[:, :, measured]), samples, 1)
    return evidence_of(evenly(starts, PREPARATION.max_starts).reshape(-1, samples * len(measured)))
