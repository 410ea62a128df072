"""How sure a prediction is: draws of the initial state, carried along, and the error of the model itself.

    variance = variance over the draws + (relative error * rms of the predicted channel)^2

The draws follow the posterior of the initial state (Laplace), whose size adapts to how well each window is explained.
The model's own error is estimated on training windows and holds for channels that were never fitted, too. Experts are
judged on the recordings that they did not see: what is true of a day they were trained on is not of the next.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.recordings import Sensor
from hybrid.estimation.config import UNCERTAINTY
from hybrid.estimation.experts import Experts, Hybrid
from hybrid.estimation.forecast import Forecast, forecast_windows, joined, posterior, solves_for_states
from hybrid.estimation.windows import evenly, evenly_chosen
from hybrid.neural_modal_ode.driving import Driving, parts_of
from hybrid.neural_modal_ode.model import Trajectory
from hybrid.neural_modal_ode.state_prior import StatePrior


@dataclass(frozen=True)
class BandedForecast:
    """A forecast and the standard deviation (window, time, sensor) of its channels, sensor noise left out."""

    forecast: Forecast
    std: FloatArray


@torch.no_grad()
def banded_forecast(
    model: Hybrid,
    windows: FloatArray,
    samples: int | None = None,
    whole: bool = False,
    driving: Driving | None = None,
) -> BandedForecast:
    """Forecast windows (window, time, sensor) as `forecast_windows` does, and say how sure it is."""
    centre, std = _with_std(model, windows, samples, whole, driving, lambda motion: motion.channels)
    return BandedForecast(joined(centre), std)


@torch.no_grad()
def banded_field(
    model: Hybrid,
    windows: FloatArray,
    shapes: FloatArray,
    samples: int | None = None,
    whole: bool = False,
    driving: Driving | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return the displacement (window, time, dof) estimated from windows, and its standard deviation.

    ``shapes`` (dof, mode): of the model's modes. The model's own error is taken as of the channels.
    """
    basis = torch.tensor(shapes).to(model.channel_scale)
    centre, std = _with_std(model, windows, samples, whole, driving, lambda motion: motion.q @ basis.T)
    return joined(centre).q @ shapes.T, std


def _with_std(
    model: Hybrid,
    windows: FloatArray,
    samples: int | None,
    whole: bool,
    driving: Driving | None,
    shown: Callable[[Trajectory], Tensor],
) -> tuple[list[Trajectory], FloatArray]:
    """Return the forecasts and the standard deviation (window, time, value) of what is ``shown`` of them."""
    generator = torch.Generator().manual_seed(UNCERTAINTY.seed)
    length = samples or windows.shape[1]
    centres, stds = [], []
    known = parts_of(driving, UNCERTAINTY.windows_per_draw_batch, len(windows))
    batches = torch.tensor(windows).to(model.channel_scale).split(UNCERTAINTY.windows_per_draw_batch)
    for batch, part in zip(batches, known, strict=True):
        own = None if part is None else part.to(batch)
        mean, root = posterior(model, batch, whole, own)
        count = UNCERTAINTY.draws if bool(root.any()) else 1  # where a state is certain, all draws of it are alike
        draws = torch.randn(count, *mean.shape, 1, generator=generator, dtype=torch.float64).to(mean)
        states = mean + (root @ draws)[..., 0]  # (draw, window, 2 mode)
        centre = model.forecast(mean, length, own)
        middle = shown(centre)
        repeated = None if own is None else own.repeated(count)
        drawn = shown(model.forecast(states.flatten(0, 1), length, repeated)).unflatten(0, states.shape[:2])
        error = model.relative_error * middle.square().mean(dim=1, keepdim=True).sqrt()
        centres.append(centre)
        stds.append(((drawn - middle).square().mean(dim=0) + error**2).sqrt())
    return centres, torch.cat(stds).cpu().double().numpy()


def relative_error(model: Hybrid, windows: FloatArray, driving: Driving | None = None) -> float:
    """Return the model's own error, relative to the size of the channels, on windows (window, time, sensor).

    Where whole windows are explained down to the sensors' noise, the noise is treated apart by being white: the
    products of misfits one and two samples apart, extrapolated to none, hold the model's error only, less what the
    fitted state takes from both. Else all of the forecast's misfit that the draws do not explain counts as the model's.
    Channels weigh by how well their noise lets them show; the median over windows.
    """
    whole = solves_for_states(model)
    before = model.relative_error.clone()
    model.relative_error.zero_()
    banded = banded_forecast(model, windows, whole=whole, driving=driving)
    model.relative_error.copy_(before)
    fitted, std = (values[:, :, model.measured] for values in (banded.forecast.channels, banded.std))
    misfit = windows[:, :, model.measured] - fitted
    if whole:
        near, far = misfit[:, 2:] * misfit[:, 1:-1], misfit[:, 2:] * misfit[:, :-2]
        excess = (4 * near - far) / 3 + std[:, 2:] ** 2  # a smooth error's correlation falls with the lag's square
    else:
        excess = misfit**2 - std**2
    size = np.mean(fitted**2, axis=1)  # (window, measured)
    clarity = np.median(np.mean(misfit**2, axis=1) / size, axis=0) ** -2.0  # of each channel: one over its variance
    shares = (excess.mean(axis=1) / size) @ (clarity / clarity.sum())  # (window,)
    return float(np.sqrt(max(np.median(shares), 0.0)))


def unseen_error(model: Experts, windows: FloatArray) -> float:
    """Return the error of experts on a recording that none of them saw, relative to the size of the channels.

    Each recording is forecast by the experts of all others; ``windows`` (window, time, sensor) are those of all
    recordings, one's after the other's. The error is what a normal one would be whose band holds as many of the misfits
    as it should: few windows far off count as what they are. Recordings weigh alike.
    """
    ends = np.cumsum(model.counts.tolist())[:-1]
    most = min(UNCERTAINTY.max_band_windows, *model.counts.tolist())
    ratios = []
    for i, own in enumerate(np.split(windows, ends)):
        unseen = evenly(own, most)
        fitted = forecast_windows(model.without(i), unseen).channels
        size = np.sqrt(np.mean(fitted**2, axis=1, keepdims=True))
        ratios.append((np.abs(unseen - fitted) / size)[:, :, model.measured])
    return float(np.quantile(np.concatenate(ratios), UNCERTAINTY.level) / UNCERTAINTY.level_sigma)


def set_relative_error(model: Hybrid, windows: FloatArray, driving: Driving | None = None) -> None:
    """Let the model know its own error, from some of its training windows (window, time, sensor)."""
    if isinstance(model, Experts) and len(model.members) > 1:
        found = unseen_error(model, windows)
    else:
        picks = torch.tensor(evenly_chosen(len(windows), UNCERTAINTY.max_band_windows))
        some = None if driving is None else driving[picks]
        found = relative_error(model, evenly(windows, UNCERTAINTY.max_band_windows), some)
    model.relative_error.fill_(found)


def noise_std(model: Hybrid, sensors: tuple[Sensor, ...]) -> FloatArray:
    """Return the noise of each sensor (sensor,), as far as the model knows it: zero where it does not.

    A sensor that is not fitted is taken to be like the fitted ones of its quantity and unit.
    """
    if isinstance(model, Experts) or not isinstance(model.encoder, StatePrior):
        return np.zeros(len(sensors))
    return like_measured(
        dict(zip(model.measured, model.encoder.noise_std.cpu().double().tolist(), strict=True)), sensors
    )


def like_measured(known: dict[int, float], sensors: tuple[Sensor, ...]) -> FloatArray:
    """Return the noise (sensor,) of all sensors from the ``known`` one of some, by their numbers; zero of others."""
    found = np.zeros(len(sensors))
    for i, sensor in enumerate(sensors):
        like = [
            std for j, std in known.items() if (sensors[j].quantity, sensors[j].unit) == (sensor.quantity, sensor.unit)
        ]
        found[i] = known.get(i, float(np.mean(like)) if like else 0.0)
    return found


def coverage(error: FloatArray, std: FloatArray) -> FloatArray:
    """Return the share (sensor,) of errors (window, time, sensor) inside the band that should hold 90 % of them."""
    inside: FloatArray = (np.abs(error) <= UNCERTAINTY.level_sigma * std).mean(axis=(0, 1))
    return inside
