"""Backbone curves: the equation by hand, what stays at rest or linear, and frequency over size as they set it."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import torch

from hybrid.neural_modal_ode.config import BACKBONE_RESIDUAL
from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.integrators import integrate
from hybrid.neural_modal_ode.residuals.backbone_residual import BackboneResidual, level_weights
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual
from hybrid.neural_modal_ode.scaling import StateScale
from hybrid.training.preparation import prepare
from tests.hybrid_problems import TINY, chain_dataset, chain_modes, double_precision

MODES = 4
BACKBONE = replace(TINY, model=replace(TINY.model, residual="backbone"))


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        torch.manual_seed(0)
        yield


def bent(size: float = 0.1) -> BackboneResidual:
    residual = BackboneResidual(MODES, 6, zero_at_rest=True)
    with torch.no_grad():
        residual.table.normal_(std=size)
    return residual


def test_weights_are_linear_between_levels_and_held_beyond() -> None:
    levels = torch.tensor([-2.0, -1.0, 0.0, 1.0])
    found = level_weights(torch.tensor([-9.0, -2.0, -0.75, 0.0, 7.0]), levels)
    expected = [[1.0, 0, 0, 0], [1, 0, 0, 0], [0, 0.75, 0.25, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    assert torch.allclose(found, torch.tensor(expected), atol=1e-15)


def test_it_starts_as_the_free_residual() -> None:
    residual, z = BackboneResidual(MODES, 6, zero_at_rest=True), torch.randn(7, 2 * MODES)
    assert torch.equal(residual(z), residual.free(z))
    assert isinstance(residual.free, FreeResidual)


def test_the_force_by_hand() -> None:
    """At a state of rms 10^-0.5, half way between the levels -2/3 and -1/3 of four from -1 to 0."""
    residual, z = bent(), torch.randn(1, 2 * MODES)
    z = z / z.square().mean().sqrt() * 10**-0.5
    rates = BACKBONE_RESIDUAL.rate_per_unit * (residual.table[1] + residual.table[2]) / 2
    expected = -(rates[:MODES] * z[0, :MODES] + rates[MODES:] * z[0, MODES:])
    assert torch.allclose(residual(z)[0], expected, rtol=1e-9)  # 1e-12 of the square keeps rest finite


def test_a_structure_at_rest_stays_at_rest_and_has_slopes() -> None:
    residual = bent()
    rest = torch.zeros(1, 2 * MODES, requires_grad=True)
    force = residual(rest)
    assert not force.any()
    (slope,) = torch.autograd.grad(force.sum(), rest)
    assert bool(torch.isfinite(slope).all())


def test_slopes_are_those_of_finite_differences() -> None:
    """Central, with steps of 1e-6: 1e-8 of curvature and rounding."""
    residual, z = bent(), torch.randn(3, 2 * MODES)
    with torch.no_grad():
        columns = [(residual(z + 1e-6 * e) - residual(z - 1e-6 * e)) / 2e-6 for e in torch.eye(2 * MODES)]
        assert torch.allclose(residual.slopes(z), torch.stack(columns, dim=-1), atol=1e-8)


@pytest.mark.parametrize("level", [0, BACKBONE_RESIDUAL.levels - 1])
def test_frequency_and_damping_depend_on_the_size_as_the_table_says(level: int) -> None:
    """Mode 1 alone, beyond the last levels, where the equation is linear: poles of s^2 + (c + d) s + w (w + k) = 0."""
    modal = chain_modes()
    residual = BackboneResidual(MODES, 6, zero_at_rest=True)
    with torch.no_grad():
        residual.table[level, 0], residual.table[level, MODES] = 0.02, 0.01
    omega = modal.omega
    dynamics = ModalDynamics(modal, (), StateScale.of_velocity(np.ones(MODES), omega), residual)
    z0 = torch.zeros(1, 2 * MODES)
    z0[0, 0] = 1e-3 if level == 0 else 1e3
    step, samples = 0.002, 2001
    with torch.no_grad():
        q = integrate(dynamics, z0, samples, step, "propagator")[0, :, 0].numpy()
    stiffness = omega[0] * (omega[0] + BACKBONE_RESIDUAL.rate_per_unit * 0.02)
    s = modal.damping_ratio[0] * omega[0] + BACKBONE_RESIDUAL.rate_per_unit * 0.01 / 2
    wd, t = np.sqrt(stiffness - s**2), step * np.arange(samples)
    exact = float(z0[0, 0]) * np.exp(-s * t) * (np.cos(wd * t) + s / wd * np.sin(wd * t))
    np.testing.assert_allclose(q, exact, rtol=0, atol=1e-5 * np.abs(exact).max())  # second order in the step: 1e-6


def test_levels_span_the_training_windows_and_the_linear_start_is_kept() -> None:
    dataset = chain_dataset()
    model, plain = prepare(dataset, BACKBONE).model, prepare(dataset, TINY).model
    residual, usual = model.dynamics.residual, plain.dynamics.residual
    assert isinstance(residual, BackboneResidual)
    assert isinstance(usual, FreeResidual)
    assert torch.equal(residual.free.rest.weight, usual.rest.weight)
    windows = torch.tensor(prepare(dataset, BACKBONE).windows)
    sizes = model.encode(windows)[0].square().mean(dim=1).log10() / 2
    inside = (sizes > residual.levels[0]) & (sizes < residual.levels[-1])
    assert float(inside.double().mean()) > 0.9
    assert torch.allclose(residual.levels.diff(), residual.levels.diff()[0])
