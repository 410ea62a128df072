"""Seconds of a whole trajectory and its gradient, beside torchdiffeq's rk4 on the same model, and how exact it is."""

import time
from collections.abc import Callable
from dataclasses import replace
from statistics import median

import torch
from torch import Tensor
from torchdiffeq import odeint

from benchmarks.row import Row
from fe_models.four_dof_data import paper_dataset
from fe_models.linear import ModalModel
from hybrid.config import Config, places_preset
from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.integrators import propagate
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.training.preparation import prepare

BATCH, SAMPLES, STEP = 16, 501, 0.1
REPEATS = 3
PAPER_HIDDEN = 128  # units a layer of the paper's NN(z)
TIGHT = 1e-10  # relative and absolute tolerance of the reference


def rows(modal: ModalModel) -> list[Row]:
    """Return the times of forward and backward passes at batch 16, 501 steps, and the error by the step."""
    dataset = paper_dataset(1.0, modal, realisations=40, progress=False)
    places = places_preset()
    free = Config(replace(Config().model, modes=4, net_hidden=PAPER_HIDDEN))
    found = []
    for name, config in (("nets at places", places), ("NN(z), 2 x 128", free)):
        dynamics = prepare(dataset, config).model.dynamics
        _let_nets_act(dynamics)
        z0 = torch.randn(BATCH, 8, generator=torch.Generator().manual_seed(0))
        ours = _seconds(dynamics, z0, _propagate)
        theirs = _seconds(dynamics, z0, _rk4)
        found.append(Row("speed", f"ms forward + backward, {name}", 1e3 * ours, "torchdiffeq rk4", 1e3 * theirs))
        aim = "20" if isinstance(dynamics.residual, ConnectorResidual) else ""
        found.append(Row("speed", f"times faster, {name}", theirs / ours, aim=aim))
    found += _orders(prepare(dataset, places).model.dynamics)
    return found


def _orders(dynamics: ModalDynamics) -> list[Row]:
    """Return the largest error over 10 s at three steps, in double precision; each half of the one before: a fourth."""
    dynamics = dynamics.double()
    _let_nets_act(dynamics)
    z0 = torch.randn(BATCH, 8, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    with torch.no_grad():
        ends = torch.tensor([0.0, 10.0], dtype=torch.float64)
        exact = odeint(dynamics, z0, ends, method="dopri5", rtol=TIGHT, atol=TIGHT)[-1]
        errors = [
            float((propagate(dynamics, z0, count + 1, 10.0 / count)[:, -1] - exact).abs().max())
            for count in (100, 200, 400)
        ]
    steps = (0.1, 0.05, 0.025)
    return [
        Row("order", f"error after 10 s, step {step:g} s", error) for step, error in zip(steps, errors, strict=True)
    ]


def _let_nets_act(dynamics: ModalDynamics) -> None:
    """Give nets that start at zero something to do."""
    generator = torch.Generator().manual_seed(2)
    with torch.no_grad():
        for parameter in dynamics.residual.parameters():
            parameter.add_(0.02 * torch.randn(parameter.shape, generator=generator).to(parameter))


def _propagate(dynamics: ModalDynamics, z0: Tensor) -> Tensor:
    return propagate(dynamics, z0, SAMPLES, STEP)


def _rk4(dynamics: ModalDynamics, z0: Tensor) -> Tensor:
    return odeint(dynamics, z0, torch.arange(SAMPLES, dtype=z0.dtype) * STEP, method="rk4").transpose(0, 1)


def _seconds(dynamics: ModalDynamics, z0: Tensor, solve: Callable[[ModalDynamics, Tensor], Tensor]) -> float:
    """Return the median seconds of a solution and the gradient of its mean square."""
    spent = []
    for _ in range(REPEATS + 1):
        started = time.perf_counter()
        dynamics.zero_grad()
        solve(dynamics, z0).square().mean().backward()
        spent.append(time.perf_counter() - started)
    return median(spent[1:])
