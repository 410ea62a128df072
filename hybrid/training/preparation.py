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
from fe_models.errors import InputError
from fe_models.linear import LinearModel, ModalModel
from fe_models.nominal import nominal_modes
from fe_models.progress import nothing
from fe_models.recordings import Dataset, Recording
from fe_models.structure import Structure
from hybrid.config import Config
from hybrid.estimation.config import LINEAR_CALIBRATION
from hybrid.estimation.experts import Kind
from hybrid.estimation.forecast import posterior
from hybrid.estimation.linear_calibration import (
    Observer,
    as_modelled,
    fit_linear_rest,
    free_part,
    initial_state_estimator,
    smooth,
)
from hybrid.estimation.windows import columns, cut, cut_all, cut_driving, evenly, evenly_chosen, window_length
from hybrid.identification.agreement import largest_agreeing_group
from hybrid.known_loads.modal_input import ModalInput, modal_input
from hybrid.neural_modal_ode.connectors import Connectors, chain_connectors, complete_basis
from hybrid.neural_modal_ode.driving import Driving
from hybrid.neural_modal_ode.encoder import WindowEncoder
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.residuals.backbone_residual import BackboneResidual
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual
from hybrid.neural_modal_ode.scaling import StateScale, channel_scale
from hybrid.neural_modal_ode.state_prior import StatePrior
from hybrid.training.config import PREPARATION
from hybrid.training.consistency import unexplained_shares
from hybrid.training.trainable import trainable


@dataclass(frozen=True)
class Prepared(Generic[Kind]):
    """A model at its start and the windows (window, time, sensor) it trains on, from the recordings that are ``kept``.

    ``driving``: what is known to drive the windows, None where they are free motions.
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
    driving: Driving | None = None


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
    dataset = trainable(dataset)
    recordings = training_recordings(dataset)
    measured = columns(dataset, "measured")
    length, stride = window_length(dataset, config), config.training.stride
    modal = nominal_modes(dataset, config.model.modes)
    forces = modal_input(dataset, modal, recordings)
    step = 1 / dataset.sampling_rate
    if not config.training.calibrate:
        windows, driving = cut_all(recordings, length, stride), cut_driving(forces, recordings, length, stride)
        scale = StateScale.unit(len(modal.omega))
        model = _model(config, dataset, modal, torch.ones(len(dataset.sensors)), scale, step)
        return Prepared(model, modal, windows, tuple(recording.name for recording in recordings), driving=driving)
    connectors = connectors_of(dataset, modal) if config.model.residual == "places" else None
    damping = None if connectors is None else modal_damping_matrix(dataset, modal)
    observer = Observer(modal, [dataset.sensors[i] for i in measured], step, connectors, damping)
    bent = bool(known_laws(dataset))  # a linear model would take the structure's own laws for springs and dashpots
    kept = recordings if bent else agreeing_recordings(observer, recordings, measured, length, advance, forces)
    windows, driving = cut_all(kept, length, stride), cut_driving(forces, kept, length, stride)
    some = torch.tensor(evenly(windows[:, :, measured], PREPARATION.max_calibration_windows))
    picks = torch.tensor(evenly_chosen(len(windows), PREPARATION.max_calibration_windows))
    known = None if driving is None else driving[picks].of_sensors(measured)
    fit = as_modelled(observer, some, known) if bent else fit_linear_rest(observer, some, advance, known)
    rest = torch.tensor(fit.rest)
    observability = observer.matrix(rest, fit.samples)
    some = free_part(observer, rest, some[:, : fit.samples], known)
    states, _ = smooth(observability, some)  # (window, 2 mode)
    moving = None if known is None else observer.states(rest, known.first(fit.samples), states).flatten(0, 1)
    states = states if moving is None else moving  # forces move windows that begin at rest
    size = states.square().reshape(len(states), 2, -1).mean(dim=(0, 1)).sqrt().numpy()
    scale = StateScale.of_velocity(np.maximum(size, PREPARATION.least_mode_share * size.max()), modal.omega)
    channels = torch.tensor(channel_scale(windows))
    model = _model(config, dataset, modal, channels, scale, step, connectors)
    start_at_linear_model(model, observer, rest)
    set_encoder(model, observer, observability, some, moving)
    if isinstance(model.dynamics.residual, BackboneResidual):
        if moving is None:
            starts, _ = posterior(model, torch.tensor(windows, dtype=model.channel_scale.dtype))
        else:
            starts = (moving / state_size(model, observer)).to(model.channel_scale)
        model.dynamics.residual.set_levels(starts)
    names = tuple(recording.name for recording in kept)
    left_out = tuple(recording.name for recording in recordings if recording.name not in names)
    return Prepared(model, modal, windows, names, connectors, left_out, fit.unexplained, driving)


def training_recordings(dataset: Dataset) -> tuple[Recording, ...]:
    """Return the recordings to train on; `InputError` where there are none."""
    if not dataset.select("train") or not columns(dataset, "measured"):
        raise InputError("the dataset has no training recording or no measured sensor: give at least one of each")
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
    forces: ModalInput | None = None,
) -> tuple[Recording, ...]:
    """Return the recordings that one structure can have made: the largest group that agrees; all, if they are two.

    ``forces``: how what drives them enters.
    """
    if len(recordings) < PREPARATION.min_recordings_to_compare:
        return recordings
    stride, most = max(length // 5, 1), PREPARATION.max_consistency_windows
    windows = [torch.tensor(evenly(cut(each, length, stride)[:, :, measured], most)) for each in recordings]
    drivings = list[Driving | None]()
    for recording in recordings:
        own = cut_driving(forces, [recording], length, stride)
        picks = None if own is None else torch.tensor(evenly_chosen(len(own.courses), most))
        drivings.append(None if own is None or picks is None else own[picks].of_sensors(measured))
    shares = unexplained_shares(observer, windows, advance, drivings)
    return tuple(recordings[i] for i in largest_agreeing_group(shares))


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


def state_size(model: NeuralModalODE, observer: Observer) -> Tensor:
    """Return the size (2 mode,) of the observer's state [omega q, q'] whose scaled state is one."""
    return torch.cat([observer.omega * model.dynamics.a.double(), model.dynamics.b.double()])


def set_encoder(
    model: NeuralModalODE, observer: Observer, observability: Tensor, windows: Tensor, moving: Tensor | None = None
) -> None:
    """Start the encoder at the best linear estimate, or give it what the windows (measured channels) say beforehand.

    ``windows``: without what known forces move from rest; ``moving`` (n, 2 mode): the states under these forces, with
    any of which a window may begin; None of free motions.
    """
    encoder, samples = model.encoder, model.config.encoder_samples
    size = state_size(model, observer)
    with torch.no_grad():
        if isinstance(encoder, WindowEncoder):
            channels = model.channel_scale[model.measured].double().repeat(samples)
            estimator = initial_state_estimator(observability, windows, samples, moving)
            encoder.linear.weight.copy_(estimator * channels / size[:, None])
        elif isinstance(encoder, StatePrior):
            span = min(PREPARATION.smoothing_span * samples, windows.shape[1])
            states, fitted = smooth(observability[:span], windows[:, :span])
            scaled = (states if moving is None else moving) / size
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
