"""From a dataset to a model ready to train: modes, windows, scales, and the start that linear calibration gives."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic

import numpy as np
import torch
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.causes import ForceLaw
from fe_models.causes.laws import force_laws
from fe_models.damping import full_damping
from fe_models.errors import InputError, raise_faults
from fe_models.linear import LinearModel, ModalModel
from fe_models.nominal import nominal_modes
from fe_models.progress import nothing
from fe_models.recordings import Dataset, Recording
from fe_models.structure import Structure
from hybrid.config import Config
from hybrid.estimation.config import LINEAR_CALIBRATION
from hybrid.estimation.experts import Kind
from hybrid.estimation.forecast import posterior
from hybrid.estimation.linear_calibration import Observer, as_modelled, fit_linear_rest, initial_state_estimator, smooth
from hybrid.estimation.windows import columns, cut, cut_all, evenly, window_length
from hybrid.identification.agreement import largest_agreeing_group
from hybrid.neural_modal_ode.connectors import Connectors, chain_connectors, complete_basis
from hybrid.neural_modal_ode.encoder import WindowEncoder
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.residuals.backbone_residual import BackboneResidual
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual
from hybrid.neural_modal_ode.scaling import StateScale, channel_scale
from hybrid.neural_modal_ode.state_prior import StatePrior
from hybrid.training.config import PREPARATION
from hybrid.training.consistency import unexplained_shares


@dataclass(frozen=True)
class Prepared(Generic[Kind]):
    """A model at its start and the windows (window, time, sensor) it trains on, from the recordings that are ``kept``.

    ``connectors``: the places of a residual that is tied to them, None for a free one. ``left_out`` names training
    recordings that contradict the others; ``unexplained`` is the share of the windows' energy that the calibrated
    linear model leaves (None where nothing was calibrated).
    """

    model: Kind
    modal: ModalModel
    windows: FloatArray
    kept: tuple[str, ...]
    connectors: Connectors | None = None
    left_out: tuple[str, ...] = ()
    unexplained: float | None = None


def calibration_steps(dataset: Dataset, config: Config) -> int:
    """Return how often, at most, the preparation of ``config`` will call ``advance``."""
    if not config.training.calibrate:
        return 0
    recordings = len(dataset.select("train"))
    models = recordings if config.model.experts else 1
    return len(LINEAR_CALIBRATION.window_shares) * (
        models + (recordings if recordings >= PREPARATION.min_recordings_to_compare else 0)
    )


def prepare(dataset: Dataset, config: Config, advance: Callable[[], object] = nothing) -> Prepared[NeuralModalODE]:
    """Return the starting model of ``config`` for the dataset's training recordings; `InputError` where it has none."""
    dataset = dataset.of_one_rate("training")
    recordings = training_recordings(dataset)
    measured = columns(dataset, "measured")
    length = window_length(dataset, config)
    modal = nominal_modes(dataset, config.model.modes)
    step = 1 / dataset.sampling_rate
    if not config.training.calibrate:
        windows = cut_all(recordings, length, config.training.stride)
        scale = StateScale.unit(len(modal.omega))
        model = _model(config, dataset, modal, torch.ones(len(dataset.sensors)), scale, step)
        return Prepared(model, modal, windows, tuple(recording.name for recording in recordings))
    connectors = connectors_of(dataset, modal) if config.model.residual == "places" else None
    damping = None if connectors is None else modal_damping_matrix(dataset, modal)
    observer = Observer(modal, [dataset.sensors[i] for i in measured], step, connectors, damping)
    bent = bool(known_laws(dataset))  # a linear model would take the structure's own laws for springs and dashpots
    kept = recordings if bent else agreeing_recordings(observer, recordings, measured, length, advance)
    windows = cut_all(kept, length, config.training.stride)
    some = torch.tensor(evenly(windows[:, :, measured], PREPARATION.max_calibration_windows))
    fit = as_modelled(observer, some) if bent else fit_linear_rest(observer, some, advance)
    rest = torch.tensor(fit.rest)
    observability = observer.matrix(rest, fit.samples)
    some = some[:, : fit.samples]
    states, _ = smooth(observability, some)  # (window, 2 mode)
    size = states.square().reshape(len(states), 2, -1).mean(dim=(0, 1)).sqrt().numpy()
    scale = StateScale.of_velocity(np.maximum(size, PREPARATION.least_mode_share * size.max()), modal.omega)
    channels = torch.tensor(channel_scale(windows))
    model = _model(config, dataset, modal, channels, scale, step, connectors)
    start_at_linear_model(model, observer, rest)
    set_encoder(model, observer, observability, some)
    if isinstance(model.dynamics.residual, BackboneResidual):
        starts, _ = posterior(model, torch.tensor(windows, dtype=model.channel_scale.dtype))
        model.dynamics.residual.set_levels(starts)
    names = tuple(recording.name for recording in kept)
    left_out = tuple(recording.name for recording in recordings if recording.name not in names)
    return Prepared(model, modal, windows, names, connectors, left_out, fit.unexplained)


def training_recordings(dataset: Dataset) -> tuple[Recording, ...]:
    """Return the recordings to train on; `InputError` where there are none, or where they cannot be trained on."""
    dataset.require_recordings("training")
    faults = [
        f"recording {recording.name!r} names loads or base motion: the hybrid model learns from free vibrations only;"
        " leave it out"
        for recording in dataset.recordings
        if recording.is_driven
    ]
    if not dataset.select("train") or not columns(dataset, "measured"):
        faults.append("the dataset has no training recording or no measured sensor: give at least one of each")
    raise_faults(faults)
    return dataset.select("train")


def known_laws(dataset: Dataset) -> tuple[ForceLaw, ...]:
    """Return the forces that the dataset's structure has by itself, beyond its matrices."""
    return () if isinstance(dataset.model, LinearModel) else force_laws(dataset.model)


def modal_damping_matrix(dataset: Dataset, modal: ModalModel) -> FloatArray | None:
    """Return Phi^T C Phi (mode, mode) of the structure's own damping, None where the dataset assumes another.

    Dashpots couple the modes, which a modal model's ratios leave out.
    """
    assumed = dataset.assumptions
    if not isinstance(dataset.model, Structure) or assumed.damping_ratio is not None or assumed.modal_model is not None:
        return None
    shapes = modal.shapes[modal.dofs.free_rows]
    return np.asarray(shapes.T @ full_damping(linearise(dataset.model)) @ shapes)


def connectors_of(dataset: Dataset, modal: ModalModel) -> Connectors:
    """Return the places of the dataset's structure, which must be a chain with all its modes."""
    chain = dataset.model
    if not isinstance(chain, Structure) or chain.directions != ("x",) or not complete_basis(modal):
        raise InputError("a residual tied to places needs a chain with as many modes as degrees of freedom")
    return chain_connectors(chain, linearise(chain), modal)


def agreeing_recordings(
    observer: Observer,
    recordings: tuple[Recording, ...],
    measured: list[int],
    length: int,
    advance: Callable[[], object] = nothing,
) -> tuple[Recording, ...]:
    """Return the recordings that one structure can have made: the largest group that agrees; all, if they are two."""
    if len(recordings) < PREPARATION.min_recordings_to_compare:
        return recordings
    windows = [
        torch.tensor(
            evenly(cut(recording, length, max(length // 5, 1))[:, :, measured], PREPARATION.max_consistency_windows)
        )
        for recording in recordings
    ]
    return tuple(recordings[i] for i in largest_agreeing_group(unexplained_shares(observer, windows, advance)))


def start_at_linear_model(model: NeuralModalODE, observer: Observer, rest: Tensor) -> None:
    """Set the learned linear part of ``model`` to the calibrated one."""
    residual, a, b = model.dynamics.residual, model.dynamics.a.double(), model.dynamics.b.double()
    if isinstance(residual, ConnectorResidual):
        residual.set_coefficients(*rest)
    elif isinstance(residual, FreeResidual | BackboneResidual):
        free = residual.free if isinstance(residual, BackboneResidual) else residual
        stiffness, damping = observer.rates(rest)
        nominal_stiffness, nominal_damping = observer.rates(torch.zeros_like(rest))
        extra = torch.cat(
            [(stiffness - nominal_stiffness) * (observer.omega * a), (damping - nominal_damping) * b], dim=1
        )
        with torch.no_grad():
            free.rest.weight.copy_(extra / b[:, None])  # (mode, 2 mode)


def set_encoder(model: NeuralModalODE, observer: Observer, observability: Tensor, windows: Tensor) -> None:
    """Start the encoder at the best linear estimate, or give it what the windows (measured channels) say beforehand."""
    encoder, samples = model.encoder, model.config.encoder_samples
    size = torch.cat([observer.omega * model.dynamics.a.double(), model.dynamics.b.double()])  # (2 mode,)
    with torch.no_grad():
        if isinstance(encoder, WindowEncoder):
            channels = model.channel_scale[model.measured].double().repeat(samples)
            estimator = initial_state_estimator(observability, windows, samples)
            encoder.linear.weight.copy_(estimator * channels / size[:, None])
        elif isinstance(encoder, StatePrior):
            span = min(PREPARATION.smoothing_span * samples, windows.shape[1])
            states, fitted = smooth(observability[:span], windows[:, :span])
            scaled = states / size
            spread = scaled.T @ scaled / len(scaled)
            encoder.precision.copy_(
                torch.linalg.inv(
                    spread + PREPARATION.least_mode_share * torch.eye(len(size)) * spread.diagonal().mean()
                )
            )
            freedom = 1 - observability.shape[2] / (span * windows.shape[2])
            noise = (windows[:, :span] - fitted).square().mean(dim=(0, 1)) / freedom
            encoder.noise_std.copy_(noise.sqrt())


def _model(
    config: Config,
    dataset: Dataset,
    modal: ModalModel,
    channels: Tensor,
    scale: StateScale,
    step: float,
    connectors: Connectors | None = None,
) -> NeuralModalODE:
    effects = known_laws(dataset)
    with torch.random.fork_rng(devices=[]):  # the caller's random numbers stay as they are
        torch.manual_seed(config.training.seed)
        return NeuralModalODE(config.model, modal, effects, dataset.sensors, channels, scale, step, connectors)
