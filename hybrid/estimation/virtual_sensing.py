"""Virtual sensing: the motion of the whole structure under unknown forces, from all samples of a recording at once.

    q'' = -Lambda q - Gamma q' + learned rest + b g,    g white, of one size a mode

The learned model is linearised along its own motion, A + B J at each sample, and carried over a step exactly for a
force that is constant there; states and forces are those of the smoother (`unknown_forces`), along which the model is
linearised anew (Bell, SIAM J. Optim. 4(3), 1994). The sizes of the modes' forces and of the sensors' noise are those
under which the recording is most probable; the gradient of that is what the smoother expects of their squares.
"""

from copy import deepcopy
from dataclasses import dataclass, replace

import numpy as np
import torch
from scipy.optimize import minimize
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from hybrid.estimation.config import SENSING
from hybrid.estimation.experts import Hybrid, members_of
from hybrid.estimation.forecast import Forecast
from hybrid.estimation.unknown_forces import Smoothed, StepModel, smoothed
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.residuals.free_residual import NoResidual


@dataclass(frozen=True, eq=False)
class SensedMotion:
    """The ``motion`` (one window) about its mean, the standard deviation of its channels (time, sensor), sensors' noise
    left out, and the ``covariance`` (time, mode, mode) of its modal coordinates.

    ``force_std`` (mode,): of the modal force over each step, N / sqrt(kg); ``noise_std`` (measured,): of the sensors.
    """

    motion: Forecast
    channels_std: FloatArray
    covariance: FloatArray
    force_std: FloatArray
    noise_std: FloatArray
    log_likelihood: float

    def field_std(self, shapes: FloatArray) -> FloatArray:
        """Return the standard deviation (time, dof) of the displacement of ``shapes`` (dof, mode)."""
        variance = np.stack([np.sum((shapes @ each) * shapes, axis=1) for each in self.covariance])
        return np.sqrt(np.maximum(variance, 0.0))

    def part(self, begin: int, end: int) -> "SensedMotion":
        """Return the samples from ``begin`` to before ``end``."""
        motion = Forecast(*(values[:, begin:end] for values in vars(self.motion).values()))
        spread = {name: getattr(self, name)[begin:end] for name in ("channels_std", "covariance")}
        return replace(self, motion=motion, **spread)


def sense(model: Hybrid, data: FloatArray) -> SensedMotion:
    """Return the motion that ``data`` (time, sensor) show, about their mean; of experts by the most probable one.

    `InputError` where a recording is too short, or the model does not explain it with any forces.
    """
    if len(data) < SENSING.min_samples:
        raise InputError(f"{len(data)} samples are too few to estimate unknown forces: give {SENSING.min_samples}")
    return max((_sensed(member, data) for member in members_of(model)), key=lambda found: found.log_likelihood)


@torch.no_grad()
def _sensed(model: NeuralModalODE, data: FloatArray) -> SensedMotion:
    model = deepcopy(model).cpu().double()
    seen = (data - data.mean(axis=0))[:, model.measured]
    modes = model.dynamics.modes
    steps = step_model(model, torch.zeros(1, 2 * modes, dtype=torch.float64))
    sizes, begin = _start(steps.measured(model.measured), seen)
    is_linear = isinstance(model.dynamics.residual, NoResidual) and not model.dynamics.effects
    for number in range(1 if is_linear else SENSING.linearisations):
        own = steps.measured(model.measured)
        sizes = likely_sizes(own, seen, sizes, begin) if number < SENSING.size_searches else sizes
        found = smoothed(own, seen, *sizes, (np.zeros(2 * modes), begin))
        if not np.isfinite(found.states).all():
            raise InputError("the model's motion under unknown forces grows beyond all bounds: train it again")
        last = is_linear or number + 1 == SENSING.linearisations
        steps = steps if last else step_model(model, torch.tensor(found.states))
    return _motion(model, steps, found, sizes)


@dataclass(frozen=True, eq=False)
class _Steps(StepModel):
    """Steps with all sensors of the model among their channels."""

    def measured(self, columns: list[int]) -> StepModel:
        """Return those with the measured channels alone."""
        output, offset = self.output[:, columns], self.offset[:, columns]
        return StepModel(self.transition, self.feed, self.drift, output, self.direct[columns], offset)


def step_model(model: NeuralModalODE, states: Tensor) -> _Steps:
    """Return the model's steps, linearised along ``states`` (time, 2 mode); one for all, where there is one state."""
    dynamics, modes = model.dynamics, model.dynamics.modes
    unit = torch.eye(3 * modes, dtype=states.dtype)
    shown = model.decode(unit[:, : 2 * modes], unit[:, 2 * modes :]).T  # (sensor, 2 mode + mode)
    A, parts = dynamics.linear_part(), []
    for some in states.split(SENSING.states_at_once):
        J = dynamics.force_slopes(some)  # (time, mode, 2 mode)
        left = dynamics.force(some) - torch.einsum("tij,tj->ti", J, some)  # (time, mode)
        augmented = torch.zeros(len(some), 3 * modes, 3 * modes, dtype=states.dtype)
        augmented[:, : 2 * modes, : 2 * modes] = A
        augmented[:, modes : 2 * modes, : 2 * modes] += J
        augmented[:, modes : 2 * modes, 2 * modes :] = torch.eye(modes, dtype=states.dtype)
        block = torch.matrix_exp(augmented * model.step)[:, : 2 * modes]
        fed = block[..., 2 * modes :]
        drift = torch.einsum("tij,tj->ti", fed, left)
        seen = shown[:, : 2 * modes] + shown[:, 2 * modes :] @ J
        parts.append((block[..., : 2 * modes], fed, drift, seen, left @ shown[:, 2 * modes :].T))
    transition, feed, moved, output, offset = [torch.cat(each).numpy() for each in zip(*parts, strict=True)]
    return _Steps(transition, feed, moved, output, shown[:, 2 * modes :].numpy(), offset)


def _start(steps: StepModel, data: FloatArray) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
    """Return sizes of forces and noise to start from, and the covariance of the first state.

    One size of all modes' forces that explains the channels' energy; ten times the states' covariance under them.
    """
    A, B = steps.transition[0], steps.feed[0]
    A = A * min(1.0, SENSING.max_spectral_radius / np.abs(np.linalg.eigvals(A)).max())
    P = B @ B.T
    for _ in range(SENSING.doublings):
        P, A = P + A @ P @ A.T, A @ A
    power = data.var(axis=0)
    shown = np.diag(steps.output[0] @ P @ steps.output[0].T + steps.direct @ steps.direct.T)
    size = float(np.median(power / np.maximum(shown, np.finfo(float).tiny)))
    force = np.full(B.shape[1], size)
    return (force, SENSING.first_noise_share * power), SENSING.first_state_ratio * size * P


def likely_sizes(
    steps: StepModel, data: FloatArray, sizes: tuple[FloatArray, FloatArray], begin: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the variances of forces (mode,) and noise (measured,) under which a stretch of data is most probable.

    ``begin``: the covariance of the first state; ``sizes``: where the search begins.
    """
    few = slice(0, SENSING.max_samples)
    some = (
        steps
        if len(steps.transition) == 1
        else StepModel(
            steps.transition[few], steps.feed[few], steps.drift[few], steps.output[few], steps.direct, steps.offset[few]
        )
    )
    stretch, modes, mean = data[few], len(sizes[0]), np.zeros(len(begin))
    first = np.log(np.concatenate(sizes))

    def cost(logarithms: FloatArray) -> tuple[float, FloatArray]:
        variances = np.exp(logarithms)
        found = smoothed(some, stretch, variances[:modes], variances[modes:], (mean, begin))
        slope = 0.5 * (np.concatenate([found.force_power, found.noise_power]) / variances - 1)
        return -found.log_likelihood / len(stretch), -slope

    bounds = [(value - SENSING.log_range, value + SENSING.log_range) for value in first]
    best = minimize(cost, first, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": SENSING.iterations})
    variances = np.exp(best.x)
    return variances[:modes], variances[modes:]


def _motion(
    model: NeuralModalODE, steps: _Steps, found: Smoothed, sizes: tuple[FloatArray, FloatArray]
) -> SensedMotion:
    """Return what the smoother found in modal coordinates and at all sensors, those that were not measured, too."""
    z, g = torch.tensor(found.states), torch.tensor(found.forces)
    dynamics, modes = model.dynamics, model.dynamics.modes
    q, q_dot = dynamics.unscale(z)
    q_ddot = dynamics.acceleration(z, dynamics.force(z) + g)
    shown = model.decoder(q, q_dot, q_ddot)
    samples, sensors = len(z), steps.output.shape[1]
    rows = np.concatenate(
        [
            np.broadcast_to(steps.output, (samples, *steps.output.shape[1:])),
            np.broadcast_to(steps.direct, (samples, *steps.direct.shape)),
        ],
        axis=2,
    )
    variance = np.zeros((samples, sensors))
    for part in np.array_split(np.arange(samples), samples // SENSING.states_at_once + 1):
        variance[part] = np.einsum("tsi,tij,tsj->ts", rows[part], found.covariance[part], rows[part], optimize=True)
    a, b = dynamics.a.numpy(), dynamics.b.numpy()
    return SensedMotion(
        motion=Forecast(*(part.numpy()[None] for part in (q, q_dot, q_ddot, shown))),
        channels_std=np.sqrt(np.maximum(variance, 0.0)),
        covariance=found.covariance[:, :modes, :modes] * np.outer(a, a),
        force_std=np.sqrt(sizes[0]) * b,
        noise_std=np.sqrt(sizes[1]),
        log_likelihood=found.log_likelihood,
    )
