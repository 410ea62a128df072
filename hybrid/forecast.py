"""Forecasts of windows from their first samples: by the hybrid model, or by its FE counterpart from the same start."""

from dataclasses import dataclass

import numpy as np
import torch

from fe_models.dofs import FloatArray
from hybrid.experts import Hybrid
from hybrid.model import Trajectory

BATCH = 64  # windows at a time: bounds memory


@dataclass(frozen=True)
class Forecast:
    """Modal coordinates and rates (window, time, mode), and channels (window, time, sensor)."""

    q: FloatArray
    q_dot: FloatArray
    q_ddot: FloatArray
    channels: FloatArray


@torch.no_grad()
def forecast_windows(
    model: Hybrid, windows: FloatArray, dynamics: Hybrid | None = None, samples: int | None = None
) -> Forecast:
    """Forecast windows (window, time, sensor) from their first samples, starting at the mean of q(z0 | samples).

    ``dynamics`` (the FE counterpart, say) forecasts in place of ``model``, from the state that ``model`` encodes;
    ``samples`` of them, or as many as the windows have.
    """
    parameter = next(model.parameters())
    parts: list[Trajectory] = []
    for start in range(0, len(windows), BATCH):
        batch = torch.tensor(windows[start : start + BATCH], dtype=parameter.dtype, device=parameter.device)
        state = model.initial_state(batch)
        parts.append((dynamics or model).forecast(state, samples or windows.shape[1]))
    return _joined(parts)


@torch.no_grad()
def generate(model: Hybrid, q: FloatArray, q_dot: FloatArray, samples: int) -> Forecast:
    """Return the motion (1, time, ...) from modal coordinates and velocities (mode,) that the user sets."""
    parameter = next(model.parameters())
    state = [torch.tensor(values[None], dtype=parameter.dtype, device=parameter.device) for values in (q, q_dot)]
    return _joined([model.forecast(model.scale_state(*state), samples)])


def _joined(parts: list[Trajectory]) -> Forecast:
    def join(name: str) -> FloatArray:
        return np.concatenate([getattr(part, name).cpu().double().numpy() for part in parts])

    return Forecast(join("q"), join("q_dot"), join("q_ddot"), join("channels"))
