"""From a dataset to a model ready to train: modes, windows, scales, and the start that linear calibration gives."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from fe_models.dofs import FloatArray
from fe_models.errors import raise_faults
from fe_models.linear import LinearModel, ModalModel
from fe_models.nominal import nominal_modes
from fe_models.recordings import Dataset, Recording
from hybrid.calibration import GROWTH, Observer, fit_linear_rest, initial_state_estimator, nothing, smooth
from hybrid.config import Config
from hybrid.consistency import largest_agreeing_group, unexplained_shares
from hybrid.encoder import WindowEncoder
from hybrid.model import NeuralModalODE
from hybrid.scaling import StateScale, channel_scale
from hybrid.windows import columns, cut, cut_all, window_length

CALIBRATION_WINDOWS = 200  # at most; evenly chosen, more add time but little information
CONSISTENCY_WINDOWS = 30  # at most, of each recording
FEWEST_TO_COMPARE = 3  # training recordings: of two that disagree nobody knows which to leave out
FAINT = 1e-3  # of the strongest mode's size: the least size a mode is scaled with


@dataclass(frozen=True)
class Prepared:
    """A model at its start and the windows (window, time, sensor) it trains on, from the recordings that are ``kept``.

    ``left_out`` names training recordings that contradict the others; ``unexplained`` is the share of the windows'
    energy that the calibrated linear model leaves (None where nothing was calibrated).
    """

    model: NeuralModalODE
    modal: ModalModel
    windows: FloatArray
    kept: tuple[str, ...]
    left_out: tuple[str, ...] = ()
    unexplained: float | None = None


def calibration_steps(dataset: Dataset, config: Config) -> int:
    """Return how often `prepare` will call ``advance``."""
    if not config.training.calibrate:
        return 0
    recordings = len(dataset.select("train"))
    return len(GROWTH) * (1 + (recordings if recordings >= FEWEST_TO_COMPARE else 0))


def prepare(dataset: Dataset, config: Config, advance: Callable[[], object] = nothing) -> Prepared:
    """Return the starting model of ``config`` for the dataset's training recordings; `InputError` where it has none."""
    recordings = dataset.select("train")
    measured = columns(dataset, "measured")
    faults = [
        f"recording {recording.name!r} names loads: the hybrid model learns from free vibrations only; leave it out"
        for recording in dataset.recordings
        if recording.loads
    ]
    if not recordings or not measured:
        faults.append("the dataset has no training recording or no measured sensor: give at least one of each")
    raise_faults(faults)
    length = window_length(dataset, config.training.window, config.model.encoder_samples)
    modal = nominal_modes(dataset, config.model.modes)
    step = 1 / dataset.sampling_rate
    if not config.training.calibrate:
        windows = cut_all(recordings, length, config.training.stride)
        scale = StateScale.unit(len(modal.omega))
        model = _model(config, dataset, modal, torch.ones(len(dataset.sensors)), scale, step)
        return Prepared(model, modal, windows, tuple(recording.name for recording in recordings))
    observer = Observer(modal, [dataset.sensors[i] for i in measured], step)
    kept = agreeing_recordings(observer, recordings, measured, length, advance)
    windows = cut_all(kept, length, config.training.stride)
    some = torch.tensor(_evenly(windows[:, :, measured], CALIBRATION_WINDOWS))
    fit = fit_linear_rest(observer, some, advance)
    rest = torch.tensor(fit.rest)
    observability = observer.matrix(rest, length)
    states, _ = smooth(observability, some)  # (window, 2 mode)
    size = states.square().reshape(len(states), 2, -1).mean(dim=(0, 1)).sqrt().numpy()
    scale = StateScale.of_velocity(np.maximum(size, FAINT * size.max()), modal.omega)
    channels = torch.tensor(channel_scale(windows))
    model = _model(config, dataset, modal, channels, scale, step)
    estimator = initial_state_estimator(observability, some, config.model.encoder_samples)
    start_at_linear_model(model, observer, rest, estimator)
    names = tuple(recording.name for recording in kept)
    left_out = tuple(recording.name for recording in recordings if recording.name not in names)
    return Prepared(model, modal, windows, names, left_out, fit.unexplained)


def agreeing_recordings(
    observer: Observer,
    recordings: tuple[Recording, ...],
    measured: list[int],
    length: int,
    advance: Callable[[], object] = nothing,
) -> tuple[Recording, ...]:
    """Return the recordings that one structure can have made: the largest group that agrees; all, if they are two."""
    if len(recordings) < FEWEST_TO_COMPARE:
        return recordings
    windows = [
        torch.tensor(_evenly(cut(recording, length, max(length // 5, 1))[:, :, measured], CONSISTENCY_WINDOWS))
        for recording in recordings
    ]
    return tuple(recordings[i] for i in largest_agreeing_group(unexplained_shares(observer, windows, advance)))


def start_at_linear_model(model: NeuralModalODE, observer: Observer, rest: Tensor, estimator: Tensor) -> None:
    """Set the learned linear rest and the encoder of ``model`` to the calibrated ones (for z = [omega q, q'])."""
    dynamics = model.dynamics
    with torch.no_grad():
        stiffness, damping = observer.rates(rest)
        nominal_stiffness, nominal_damping = observer.rates(torch.zeros_like(rest))
        a, b = dynamics.a.double(), dynamics.b.double()
        extra = torch.cat(
            [(stiffness - nominal_stiffness) * (observer.omega * a), (damping - nominal_damping) * b], dim=1
        )
        dynamics.rest.weight.copy_(extra / b[:, None])  # (mode, 2 mode)
        if isinstance(model.encoder, WindowEncoder):
            size = torch.cat([observer.omega * a, b])  # (2 mode,)
            channels = model.channel_scale[model.measured].double().repeat(model.config.encoder_samples)
            model.encoder.linear.weight.copy_(estimator * channels / size[:, None])


def _model(
    config: Config, dataset: Dataset, modal: ModalModel, channels: Tensor, scale: StateScale, step: float
) -> NeuralModalODE:
    effects = () if isinstance(dataset.model, LinearModel) else dataset.model.effects
    with torch.random.fork_rng(devices=[]):  # the caller's random numbers stay as they are
        torch.manual_seed(config.training.seed)
        return NeuralModalODE(config.model, modal, effects, dataset.sensors, channels, scale, step)


def _evenly(windows: FloatArray, most: int) -> FloatArray:
    picks = np.linspace(0, len(windows) - 1, min(most, len(windows))).round().astype(int)
    return np.ascontiguousarray(windows[picks])
