"""What a hybrid model has left to learn: trained on a structure, its forecasts, and the force that it learned."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.causes import LoadEffect, SensorDelay, SensorDrift, SensorEffect, SensorGain
from fe_models.causes.wording import kind_words
from fe_models.errors import raise_faults
from fe_models.progress import nothing
from fe_models.recordings import Dataset, Recording
from fe_models.structure import Structure
from hybrid.config import Config, ModelConfig, places_preset
from hybrid.diagnosis.fitting.forecast_score import shown_of
from hybrid.diagnosis.learned.config import LEARNING
from hybrid.diagnosis.learned.forces import Learned, PlaceForce
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.estimation.linear_parameters import ConnectorParameters
from hybrid.estimation.most_probable_state import smooth_state, trajectory
from hybrid.estimation.windows import driving_of
from hybrid.known_loads.modal_input import modal_input
from hybrid.neural_modal_ode.driving import Driving
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.neural_modal_ode.state_prior import StatePrior
from hybrid.training.preparation import Prepared, modal_damping_matrix, prepare
from hybrid.training.trainable import trainable
from hybrid.training.trainers import trainer_for

UNDOING_ORDER = (SensorDrift, SensorGain, SensorDelay)  # faults of one sensor, as they are undone


def learning_preset(structure: object) -> Config:
    """Return the configuration for a structure: nets at a chain's places, one free net of all modes elsewhere."""
    along = isinstance(structure, Structure) and structure.is_chain and structure.directions == ("x",)
    return places_preset() if along else Config(ModelConfig(residual="backbone"))


def corrected(dataset: Dataset, findings: tuple[Finding, ...]) -> Dataset:
    """Return the dataset as sensors without the faults among ``findings`` would have recorded it.

    Each in the recordings where it acts, the last that came in first: motion is late, then scaled by a gain, then
    drifts. `InputError` where a load was recorded with a fault.
    """
    raise_faults(
        f"{kind_words(finding.cause.kind)} is a fault of a load as it was recorded, with which nothing is trained:"
        " correct the load"
        for finding in findings
        if isinstance(finding.cause, LoadEffect)
    )
    names = [sensor.name for sensor in dataset.sensors]
    faults = [(finding.cause, finding.recordings) for finding in findings if isinstance(finding.cause, SensorEffect)]
    recordings = dataset.recordings
    for fault, acting in sorted(faults, key=lambda item: UNDOING_ORDER.index(type(item[0]))):
        undone = fault.inverse()
        recordings = tuple(
            replace(r, data=_whole(undone, r, names, dataset.sampling_rate)) if r.name in acting else r
            for r in recordings
        )
    return replace(dataset, recordings=recordings)


def _whole(effect: SensorEffect, recording: Recording, names: list[str], rate: float) -> FloatArray:
    """Return a recording's data with an effect that began where it did, before what is used of it."""
    begun = np.pad(recording.data, ((0, 0), (recording.skipped, 0), (0, 0)), mode="edge")
    return effect.apply(begun, names, rate)[:, recording.skipped :]


def learn(dataset: Dataset, config: Config, advance: Callable[[], object] = nothing) -> Learned:
    """Train the hybrid on the dataset's training recordings and forecast its test recordings.

    ``advance`` is called after each epoch. `InputError` where the dataset does not allow a training,
    `TrainingDivergedError` where it fails.
    """
    torch.set_num_threads(config.training.threads)
    dataset = trainable(dataset)
    prepared = prepare(dataset, config)
    for _ in trainer_for(prepared.model, prepared.windows, config.training, driving=prepared.driving).epochs():
        advance()
    model = prepared.model
    forces = modal_input(dataset, prepared.modal, dataset.recordings)
    prior = _prior(model, prepared.windows, prepared.driving)
    scores = [
        _score(model, prior, recording.data, driving_of(forces, recording)) for recording in dataset.select("test")
    ]
    share, places = _learned(prepared, prior, dataset)
    return Learned(np.concatenate(scores), share, places)


@torch.no_grad()
def _prior(model: NeuralModalODE, windows: FloatArray, driving: Driving | None) -> StatePrior:
    """Return what the training windows say beforehand of initial states and of the noise.

    Each entry of a state by itself: how they go together cannot be estimated from a few recordings, and those of a test
    recording would be held to what the few happened to do.
    """
    seen = torch.tensor(windows, dtype=model.channel_scale.dtype)
    if isinstance(model.encoder, StatePrior):
        variance, noise = torch.linalg.inv(model.encoder.precision).diagonal(), model.encoder.noise_std
    else:
        known = None if driving is None else driving.to(seen)
        states, _ = model.encode(seen, known)
        span = 2 * model.config.encoder_samples
        error = (model.forecast(states, span, known).channels - seen[:, :span])[..., model.measured]
        variance, noise = states.square().mean(dim=0), error.square().mean(dim=(0, 1)).sqrt()
    return StatePrior(torch.diag(1 / variance.clamp(min=LEARNING.min_variance_share * float(variance.mean()))), noise)


@torch.no_grad()
def _score(model: NeuralModalODE, prior: StatePrior, data: FloatArray, driving: Driving | None) -> FloatArray:
    """Return the NRMSE (realisation, sensor) over the last 80 % of recordings (realisation, time, sensor)."""
    first = max(shown_of(data.shape[1]), model.config.encoder_samples)
    windows = torch.tensor(data, dtype=model.channel_scale.dtype)
    known = None if driving is None else driving.to(windows)
    states = smooth_state(model, prior, windows[:, :first], known).mean
    forecast = model.forecast(states, data.shape[1], known).channels.double().numpy()[:, first:]
    wanted = data[:, first:]
    return np.sqrt(np.mean((forecast - wanted) ** 2, axis=1)) / np.maximum(np.ptp(wanted, axis=1), 1e-30)


@torch.no_grad()
def _learned(
    prepared: Prepared[NeuralModalODE], prior: StatePrior, dataset: Dataset
) -> tuple[float, tuple[PlaceForce, ...]]:
    """Return the share of the acceleration that was learned, and the forces at places, along the training motion."""
    model = prepared.model
    dynamics, residual = model.dynamics, model.dynamics.residual
    states, forces = list[Tensor](), modal_input(dataset, prepared.modal, dataset.recordings)
    for recording in dataset.select("train"):
        if recording.name in prepared.kept:
            data = torch.tensor(recording.data, dtype=model.channel_scale.dtype)
            first = max(shown_of(data.shape[1]), model.config.encoder_samples)
            driving = driving_of(forces, recording)
            known = None if driving is None else driving.to(data)
            start = smooth_state(model, prior, data[:, :first], known).mean
            states.append(trajectory(model, start, data.shape[1], known)[:: model.substeps].flatten(0, 1))
    z = torch.cat(states)  # (n, 2 mode)
    if isinstance(residual, ConnectorResidual) and prepared.connectors is not None:
        form = ConnectorParameters(prepared.modal, prepared.connectors, modal_damping_matrix(dataset, prepared.modal))
        places = _at_places(residual, z, form.start().to(z.dtype), prepared.connectors.names)
        learned = -sum(place @ feed[None] for place, feed in _pairs(places, residual))
    else:
        places = ()
        learned = z @ residual.linear(dynamics.physical).T + residual(z)
    total = dynamics.acceleration(z, dynamics.force(z))
    share = float((learned * dynamics.b).square().sum() / total.square().sum())
    return share, places


def _pairs(places: tuple[PlaceForce, ...], residual: ConnectorResidual) -> list[tuple[Tensor, Tensor]]:
    """Return the force (n, 1) and the feed (mode,) of each place."""
    return [
        (torch.tensor(place.force, dtype=feed.dtype)[:, None], feed)
        for place, feed in zip(places, residual.feeds, strict=True)
    ]


def _at_places(residual: ConnectorResidual, z: Tensor, known: Tensor, names: tuple[str, ...]) -> tuple[PlaceForce, ...]:
    """Return what was learned at each place beyond the ``known`` springs and dashpots (2, place)."""
    z1, z2 = z.chunk(2, dim=-1)
    u, v = residual.elongations @ z1.T, residual.rates @ z2.T  # (place, n)
    k, c = (learned - own for learned, own in zip(residual.coefficients(), known, strict=True))
    force = k[:, None] * u + c[:, None] * v + residual.laws(u, v)
    size = force.square().mean(dim=1) * residual.feeds.square().sum(dim=1)
    numbers = [part.double().numpy() for part in (u, v, force)]
    return tuple(
        PlaceForce(name, numbers[0][i], numbers[1][i], numbers[2][i], float(size[i] / size.sum()))
        for i, name in enumerate(names)
    )
