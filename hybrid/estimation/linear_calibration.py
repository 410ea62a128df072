"""Linear calibration: the learned linear rest by separable least squares, in seconds.

For given Lambda, Gamma and rest the channels are linear in a window's initial state, so that state is solved for and
projected out (variable projection, Golub & Pereyra 1973); only the rest is searched, by L-BFGS. The windows grow from a
tenth of the whole: over a short window a frequency that is far off still has the right phase, so the search
does not get caught in a wrong minimum.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf

import torch
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.linear import ModalModel
from fe_models.progress import nothing
from fe_models.recordings import Sensor, of_each_quantity
from hybrid.estimation.config import LINEAR_CALIBRATION
from hybrid.estimation.linear_parameters import ConnectorParameters, ModalParameters
from hybrid.estimation.linear_recursion import linear_recursion
from hybrid.neural_modal_ode.connectors import Connectors
from hybrid.neural_modal_ode.decoder import sensor_shapes
from hybrid.neural_modal_ode.driving import Driving
from hybrid.observability import observability_by_doubling


@dataclass(frozen=True)
class LinearFit:
    """A learned linear ``rest``, as `Observer.rates` takes it.

    ``unexplained``: the share of the windows' energy that it leaves; ``samples``: the length of the windows fitted.
    """

    rest: FloatArray
    unexplained: float
    samples: int


class Observer:
    """What the sensors see of the linear model: x_k = C exp(A k h) z in the state z = [omega q, q']."""

    def __init__(
        self,
        modal: ModalModel,
        sensors: Sequence[Sensor],
        step: float,
        connectors: Connectors | None = None,
        damping: FloatArray | None = None,
    ) -> None:
        self.omega = torch.tensor(modal.omega, dtype=torch.float64)  # (mode,)
        shapes = torch.tensor(sensor_shapes(modal, sensors), dtype=torch.float64)  # (sensor, mode)
        picks = torch.tensor(of_each_quantity(sensors))
        self.shapes = shapes[None] * picks[:, :, None]  # (quantity, sensor, mode)
        self.step = step
        self.form = ModalParameters(modal) if connectors is None else ConnectorParameters(modal, connectors, damping)

    def rates(self, rest: Tensor) -> tuple[Tensor, Tensor]:
        """Return d q'/dt as matrices on omega q and on q', each (mode, mode), for a ``rest`` of the observer's form."""
        return self.form.rates(rest)

    def matrix(self, rest: Tensor, samples: int) -> Tensor:
        """Return the observability matrix (time, sensor, 2 mode)."""
        A, seen = self.system(rest)
        return observability_by_doubling(seen[None], torch.matrix_exp(A * self.step), samples, torch.concatenate)

    def system(self, rest: Tensor) -> tuple[Tensor, Tensor]:
        """Return A (2 mode, 2 mode) of z' = A z, and what the sensors show of z, (sensor, 2 mode)."""
        stiffness, damping = self.rates(rest)
        upper = torch.cat([torch.zeros_like(stiffness), torch.diag(self.omega)], dim=1)
        lower = torch.cat([stiffness, damping], dim=1)  # (mode, 2 mode)
        displacement, velocity, acceleration = self.shapes
        seen = torch.cat([displacement / self.omega, velocity], dim=1) + acceleration @ lower  # (sensor, 2 mode)
        return torch.cat([upper, lower]), seen

    def driven(self, rest: Tensor, driving: Driving) -> Tensor:
        """Return what the sensors show under known forces from rest, (window, time, sensor)."""
        states = self.states(rest, driving, torch.zeros(len(driving.courses), 2 * len(self.omega), dtype=torch.float64))
        return states @ self.system(rest)[1].T + driving.shown

    def states(self, rest: Tensor, driving: Driving, start: Tensor) -> Tensor:
        """Return the states (window, time, 2 mode) under known forces, from those at the ``start`` (window, 2 mode)."""
        A, _ = self.system(rest)
        transition = torch.matrix_exp(A * self.step).T
        feed = torch.cat([torch.zeros_like(driving.participation), driving.participation], dim=1).T
        return linear_recursion(start, driving.pushes(A, feed, self.step), transition)


def smooth(observability: Tensor, windows: Tensor, ridge: float = LINEAR_CALIBRATION.ridge) -> tuple[Tensor, Tensor]:
    """Return least-squares states (window, 2 mode) and the fitted windows, for (time, sensor, state) and windows."""
    X = observability.flatten(0, 1)  # (time * sensor, state)
    normal = X.T @ X
    normal = normal + ridge * normal.diagonal().mean() * torch.eye(len(normal), dtype=X.dtype)
    states = torch.linalg.solve(normal, X.T @ windows.flatten(1).T).T  # (window, state)
    return states, (states @ X.T).reshape(windows.shape)


def free_part(observer: Observer, rest: Tensor, windows: Tensor, driving: Driving | None) -> Tensor:
    """Return what windows (window, time, sensor) show beside the linear model's response to known forces."""
    return windows if driving is None else windows - observer.driven(rest, driving.first(windows.shape[1]))


def fit_linear_rest(
    observer: Observer, windows: Tensor, advance: Callable[[], object] = nothing, driving: Driving | None = None
) -> LinearFit:
    """Return the linear model that explains ``windows`` (window, time, sensor) best; ``driving``: what drives them.

    ``advance`` is called after each of the `LINEAR_CALIBRATION.window_shares` lengths, to show progress.
    """
    rms = windows.square().mean(dim=(1, 2), keepdim=True).sqrt()
    size = rms + LINEAR_CALIBRATION.quiet_share * windows.square().mean().sqrt()
    fits: list[LinearFit] = []
    for fraction in LINEAR_CALIBRATION.window_shares:
        part = windows[:, : max(round(fraction * windows.shape[1]), LINEAR_CALIBRATION.min_samples)]
        start = torch.tensor(fits[-1].rest) if fits else observer.form.start()
        fits.append(_fit(observer, part, size, start, driving))
        advance()
        if (
            observer.form.is_exact
            and fits[-1].unexplained > LINEAR_CALIBRATION.max_unexplained_ratio * fits[0].unexplained
        ):
            return fits[-2]
    return fits[-1]


def as_modelled(observer: Observer, windows: Tensor, driving: Driving | None = None) -> LinearFit:
    """Return the linear model as it is known before any learning, and what it leaves of the shortest windows."""
    rest = observer.form.start()
    short = windows[
        :, : max(round(LINEAR_CALIBRATION.window_shares[0] * windows.shape[1]), LINEAR_CALIBRATION.min_samples)
    ]
    free = free_part(observer, rest, short, driving)
    _, fitted = smooth(observer.matrix(rest, short.shape[1]), free)
    share = (fitted - free).square().mean() / short.square().mean()
    return LinearFit(rest.numpy(), share.item(), short.shape[1])


def _fit(observer: Observer, windows: Tensor, size: Tensor, start: Tensor, driving: Driving | None) -> LinearFit:
    """Return the best linear model of windows of one length, each over its ``size``, searched from ``start``."""
    energy = (windows / size).square().mean()
    rest = start.clone().requires_grad_(True)
    best, least = LinearFit(start.numpy(), 1.0, windows.shape[1]), inf
    optimiser = torch.optim.LBFGS(
        [rest],
        max_iter=LINEAR_CALIBRATION.max_iterations,
        history_size=30,
        line_search_fn="strong_wolfe",
        tolerance_change=1e-7,
    )

    def loss() -> Tensor:
        nonlocal best, least
        optimiser.zero_grad()
        free = free_part(observer, rest, windows, driving) / size
        _, fitted = smooth(observer.matrix(rest, windows.shape[1]), free)
        share = (fitted - free).square().mean() / energy
        total = share + observer.form.penalty(rest)
        total.backward()
        if total.item() < least:  # the line search may end at a worse point, or where numbers overflow
            best, least = LinearFit(rest.detach().clone().numpy(), share.item(), windows.shape[1]), total.item()
        return total

    optimiser.step(loss)
    return best


def initial_state_estimator(
    observability: Tensor, windows: Tensor, samples: int, moving: Tensor | None = None
) -> Tensor:
    """Return W (2 mode, time * sensor): the most probable z0 given a window's first ``samples``, W x.

    ``moving`` (n, 2 mode): states that a window may begin with, where those of ``windows`` are not like them.

    z0 ~ N(0, P) and x = O z0 + e with e ~ N(0, R) give W = P O^T (O P O^T + R)^-1. P and R are those of the windows,
    smoothed over six times as many samples: long enough to know z0 well, short enough for a linear model to hold.
    """
    span = min(6 * samples, windows.shape[1])
    states, fitted = smooth(observability[:span], windows[:, :span])
    error = (windows[:, :samples] - fitted[:, :samples]).flatten(1)  # (window, time * sensor)
    begun = states if moving is None else moving
    P = begun.T @ begun / len(begun)
    R = error.T @ error / len(error)
    R = R + LINEAR_CALIBRATION.covariance_shrinkage * R.diagonal().mean() * torch.eye(len(R), dtype=R.dtype)
    X = observability[:samples].flatten(0, 1)  # (time * sensor, 2 mode)
    return P @ X.T @ torch.linalg.inv(X @ P @ X.T + R)
