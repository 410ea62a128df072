"""Training a residual tied to places: few parameters, so that Gauss-Newton with exact derivatives finds them at once.

Each epoch is one step of Levenberg & Marquardt on the same windows, over a horizon that grows from epoch to epoch; each
window's initial state is solved for along with the parameters (`normal_equations`). Windows that the model does
not explain yet count little, as under a Student distribution.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np
import torch
from torch import Tensor

from fe_models.arrays import FloatArray
from hybrid.config import TrainingConfig
from hybrid.estimation.config import STATE
from hybrid.estimation.most_probable_state import by_motion, estimate_state, misfits, trajectory
from hybrid.estimation.normal_equations import normal_equations
from hybrid.levenberg_marquardt import Damping
from hybrid.neural_modal_ode.driving import Driving, parts_of
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.neural_modal_ode.state_prior import StatePrior
from hybrid.training.config import GAUSS_NEWTON
from hybrid.training.gradient_training import EpochResult, TrainingDivergedError

DAMPING = Damping(first=1e-2, easing=5.0, tightening=6.0)  # of the normal matrix's diagonal


@dataclass(frozen=True)
class WindowFit:
    """Initial states (window, 2 mode), each window's misfit and the channels' misfits (window, time, measured)."""

    states: Tensor
    misfit: Tensor
    error: Tensor


class GaussNewtonTrainer:
    """A model, its windows and the state of the search; `epochs` trains on from wherever these stand."""

    def __init__(
        self,
        model: NeuralModalODE,
        windows: FloatArray,
        config: TrainingConfig,
        device: str = "cpu",
        driving: Driving | None = None,
    ) -> None:
        residual, prior = model.dynamics.residual, model.encoder
        if not isinstance(residual, ConnectorResidual) or not isinstance(prior, StatePrior):
            raise TypeError("Gauss-Newton trains residuals tied to places, with states that are solved for")
        self.model, self.residual, self.prior = model.to(device), residual, prior
        self.config = config
        dtype = torch.get_default_dtype()
        self.windows = torch.tensor(windows, dtype=dtype, device=device)  # (window, time, sensor)
        chosen = np.random.default_rng(config.seed).permutation(len(windows))[: config.batch]
        self.chosen = self.windows[torch.as_tensor(np.sort(chosen))]
        self.driving = None if driving is None else driving.to(self.windows)
        self.chosen_driving = None if self.driving is None else self.driving[torch.as_tensor(np.sort(chosen))]
        self.states: Tensor | None = None  # (chosen, 2 mode)
        self.horizon = min(config.first_horizon, self.windows.shape[1])
        self.damping = DAMPING.start
        self.converged = False
        self.done = 0

    def state(self) -> dict[str, Any]:
        """Return where the search stands, besides the model."""
        return {
            "states": self.states,
            "horizon": self.horizon,
            "damping": self.damping,
            "converged": self.converged,
        }

    def load_state(self, state: dict[str, Any]) -> None:
        """Go on from there."""
        self.states, self.horizon = state["states"], state["horizon"]
        self.damping, self.converged = state["damping"], state["converged"]
        if self.states is not None:
            self.states = self.states.to(self.windows.device)

    @property
    def finished(self) -> bool:
        """Whether nothing changes any more, or all epochs are done."""
        return self.converged or self.done >= self.config.epochs

    def epochs(self) -> Iterator[EpochResult]:
        """Train one epoch at each step of the iteration, until nothing changes or `TrainingConfig.epochs` are done."""
        while not self.finished:
            yield self.train_epoch(self.done + 1)

    @torch.no_grad()
    def train_epoch(self, epoch: int) -> EpochResult:
        """Make one step (epoch from 1); `TrainingDivergedError` where even its start is no number."""
        horizon, length = self.horizon, self.windows.shape[1]
        windows = self.chosen[:, :horizon]
        fit = self._solve(windows, self.states)
        at_rest = not bool(fit.states.any())  # every motion that was tried overflowed
        if at_rest or not float(fit.misfit.median()) < GAUSS_NEWTON.max_misfit_per_sample * horizon * len(
            self.model.measured
        ):
            raise TrainingDivergedError(
                f"The training diverged in epoch {epoch} (forecasts of {horizon} samples)."
                " Start again with --fresh and a smaller --first-horizon."
            )
        self._follow_noise(fit.error, each=horizon > GAUSS_NEWTON.own_noise_share * length)
        fit, gain = self._step(windows, self._solve(windows, fit.states))
        self.states = fit.states
        self._follow_spread(fit, horizon)
        if gain < GAUSS_NEWTON.min_relative_gain:
            self.converged = horizon == length
        if gain < GAUSS_NEWTON.min_relative_gain or self._hurries(epoch):
            self.horizon, self.damping = min(GAUSS_NEWTON.horizon_growth * horizon, length), DAMPING.start
        self.done = epoch
        return EpochResult(epoch, float(fit.misfit.mean()), horizon)

    def _hurries(self, epoch: int) -> bool:
        """Return whether the horizon grows after an epoch, however much a step gains: on a schedule, of driven windows.

        Known forces hold the phase of a motion: long forecasts are nearly right early, and tell more than short ones.
        """
        length, first = self.windows.shape[1], min(self.config.first_horizon, self.windows.shape[1])
        if self.driving is None or self.horizon == length:
            return False
        progress = min(epoch / (GAUSS_NEWTON.growing_share * self.config.epochs), 1.0)
        return bool(self.horizon < first * (length / first) ** progress)

    def _step(self, windows: Tensor, fit: WindowFit) -> tuple[WindowFit, float]:
        """Return the fit after a step that lowers the cost, and by what share; the same fit and 0 if none is found."""
        table = self.residual.table
        scale = GAUSS_NEWTON.outlier_ratio * fit.misfit.median()
        weights = 1 / (1 + fit.misfit / scale)
        cost = _robust(fit.misfit, scale)
        parts = [
            normal_equations(self.model, self.residual, self.prior, *each)
            for each in zip(
                self._trajectories(fit.states, windows.shape[1]),
                self._measured(windows),
                weights.split(STATE.windows_per_batch),
                strict=True,
            )
        ]
        N = torch.stack([part.matrix for part in parts]).sum(dim=0)
        prior = GAUSS_NEWTON.prior_precision * torch.eye(len(N), dtype=N.dtype, device=N.device)
        downhill = torch.stack([part.downhill for part in parts]).sum(dim=0) - prior @ table.detach().flatten().double()
        floor = GAUSS_NEWTON.least_diagonal_share * N.diagonal().max()
        own, coupling = (torch.cat([getattr(part, name) for part in parts]) for name in ("own", "coupling"))
        old = table.detach().clone()
        for damping in islice(DAMPING.tries(self.damping), GAUSS_NEWTON.max_tries):
            damped = N + prior + damping * torch.diag(N.diagonal() + floor)
            move = torch.linalg.solve(damped, downhill).to(table.dtype)
            self._set(old + move.view_as(old))
            tried = self._solve(windows, fit.states + own - coupling @ move, refinements=GAUSS_NEWTON.state_refinements)
            lower = _robust(tried.misfit, scale)
            if lower < cost:
                self.damping = DAMPING.eased(damping)
                return tried, 1 - lower / cost
            self.damping = DAMPING.tightened(damping)
        self._set(old)
        return fit, 0.0

    def _solve(self, windows: Tensor, start: Tensor | None, refinements: int | None = None) -> WindowFit:
        """Return the initial states that fit the windows best, and what they leave."""
        parts = windows.split(STATE.windows_per_batch)
        starts = [None] * len(parts) if start is None else start.split(STATE.windows_per_batch)
        few = GAUSS_NEWTON.state_refinements if refinements is None else refinements
        iterations = STATE.max_iterations if start is None else few
        estimates = [
            estimate_state(self.model, self.prior, part, first, iterations, known)
            for part, first, known in zip(parts, starts, self._drivings(windows.shape[1]), strict=True)
        ]
        states, misfit = (torch.cat([getattr(e, name) for e in estimates]) for name in ("mean", "misfit"))
        errors = [
            misfits(self.model, self.prior, path, seen)[1].unflatten(1, (windows.shape[1], -1))
            for path, seen in zip(self._trajectories(states, windows.shape[1]), self._measured(windows), strict=True)
        ]
        return WindowFit(states, misfit, torch.cat(errors))

    def _trajectories(self, states: Tensor, samples: int) -> Iterator[Tensor]:
        for part, known in zip(states.split(STATE.windows_per_batch), self._drivings(samples), strict=True):
            yield trajectory(self.model, part, samples, known)

    def _measured(self, windows: Tensor) -> Iterator[Tensor]:
        drivings = self._drivings(windows.shape[1])
        for part, known in zip(windows.split(STATE.windows_per_batch), drivings, strict=True):
            yield by_motion(self.model, part, known).contiguous()

    def _drivings(self, samples: int) -> list[Driving | None]:
        known = None if self.chosen_driving is None else self.chosen_driving.first(samples)
        return parts_of(known, STATE.windows_per_batch, len(self.chosen))

    def _set(self, table: Tensor) -> None:
        self.residual.table.copy_(table)

    def _follow_noise(self, error: Tensor, each: bool) -> None:
        """Let the noise be what the model leaves: of ``each`` channel, or the same share of all channels' sizes.

        As long as a channel is explained badly, its own noise would be so large that nothing is learned from it.
        """
        # (measured,)
        std = GAUSS_NEWTON.std_over_median * error.abs().flatten(0, 1).median(dim=0).values * self.prior.noise_std
        if not each:
            size = self.windows[:, :, self.model.measured].square().mean(dim=(0, 1)).sqrt()
            std = size * (std / size).log().mean().exp()
        self.prior.noise_std.copy_(std)

    def _follow_spread(self, fit: WindowFit, horizon: int) -> None:
        """Let the prior be the spread of the states found, outlying windows counted little.

        Under known forces the states of whole motions: windows may begin with any, and many of these at rest.
        """
        weights = (1 + fit.misfit / (GAUSS_NEWTON.outlier_ratio * fit.misfit.median())).pow(-2)
        if self.driving is None:
            spread = (fit.states.T * weights) @ fit.states / weights.sum()
        else:
            moving = torch.cat(
                [path[:: self.model.substeps] for path in self._trajectories(fit.states, horizon)], dim=1
            )
            spread = torch.einsum("tbi,tbj,b->ij", moving, moving, weights) / (len(moving) * weights.sum())
        guard = (
            GAUSS_NEWTON.least_spread_share * spread.diagonal().mean() * torch.eye(len(spread), device=spread.device)
        )
        self.prior.precision.copy_(torch.linalg.inv(spread + guard))


def _robust(misfit: Tensor, scale: Tensor) -> float:
    """Return the cost of windows' misfits (window,): like their sum where they are small beside ``scale``."""
    cost = float((scale * torch.log1p(misfit / scale)).double().sum())
    return cost if np.isfinite(cost) else np.inf
