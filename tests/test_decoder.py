"""The fixed decoder: E Phi q by hand, and accelerations that are second derivatives of displacements."""

from collections.abc import Iterator

import numpy as np
import pytest
import torch

from fe_models.causes import CubicSpring
from fe_models.errors import InputError
from fe_models.recordings import Sensor
from hybrid.neural_modal_ode.decoder import Decoder, sensor_shapes
from hybrid.neural_modal_ode.integrators import propagate
from tests.hybrid_problems import SENSORS, chain_modes, double_precision, dynamics_of


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


def test_each_sensor_picks_its_row_and_its_quantity() -> None:
    modal = chain_modes()
    q, v, a = np.random.default_rng(0).standard_normal((3, 2, 7, 4))  # (window, time, mode) each
    decoded = Decoder(modal, SENSORS)(*map(torch.tensor, (q, v, a))).numpy()
    phi = modal.shapes
    by_hand = [q @ phi[3], a @ phi[0], v @ phi[1], a @ phi[2], a @ phi[3]]  # x4, a1, v2, a3, a4
    np.testing.assert_allclose(decoded, np.stack(by_hand, axis=-1), rtol=0, atol=1e-14)


def test_two_sensors_may_share_a_place() -> None:
    modal = chain_modes()
    twice = (SENSORS[0], SENSORS[4], SENSORS[4])
    np.testing.assert_array_equal(sensor_shapes(modal, twice), modal.shapes[[3, 3, 3]])


def test_accelerations_are_second_derivatives_of_displacements() -> None:
    """Of a nonlinear, damped trajectory, by fourth-order differences: h^4 x^(6) / 90 and rounding, below 1e-5."""
    modal, step = chain_modes(0.03), 0.01
    sensors = [Sensor(f"{q}{n}", n, "x", q, "1") for q in ("displacement", "velocity", "acceleration") for n in (1, 2)]
    dynamics = dynamics_of(modal, (CubicSpring((1,), "x", 1.0),), net=0.2)
    z0 = 0.5 * torch.randn(1, 8, generator=torch.Generator().manual_seed(0))
    with torch.no_grad():
        z = propagate(dynamics, z0, 400, step)
        seen = Decoder(modal, sensors)(*dynamics.unscale(z), dynamics.acceleration(z, dynamics.force(z)))[0].numpy()
    x, v, a = seen[:, :2], seen[:, 2:4], seen[:, 4:]
    first = (x[:-4] - 8 * x[1:-3] + 8 * x[3:-1] - x[4:]) / (12 * step)
    second = (-x[:-4] + 16 * x[1:-3] - 30 * x[2:-2] + 16 * x[3:-1] - x[4:]) / (12 * step**2)
    np.testing.assert_allclose(v[2:-2][5:], first[5:], rtol=0, atol=2e-4)  # the propagator's own error, h^2
    np.testing.assert_allclose(a[2:-2][5:], second[5:], rtol=0, atol=2e-4)


def test_nothing_is_learned_here() -> None:
    assert list(Decoder(chain_modes(), SENSORS).parameters()) == []


def test_all_sensors_that_the_model_lacks_are_named() -> None:
    wrong = (Sensor("p", 9, "x", "displacement", "m"), SENSORS[0], Sensor("r", 1, "y", "displacement", "m"))
    with pytest.raises(InputError) as caught:
        sensor_shapes(chain_modes(), wrong)
    assert caught.value.faults == (
        "sensor 'p': node 9 has no degree of freedom 'x'",
        "sensor 'r': node 1 has no degree of freedom 'y'",
    )
