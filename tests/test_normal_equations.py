"""The normal equations of the forces' parameters, against brute force: Jacobians by central differences.

The whole Jacobian of all channels by [z0, parameters] gives the joint least-squares problem; the product's equations
must be its Schur complement. The nets' parameters are exact; springs and dashpots count as forces that the
propagator takes explicitly, which is of second order in the step.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import pytest
import torch
from torch import Tensor

from hybrid.estimation.most_probable_state import estimate_state, trajectory
from hybrid.estimation.normal_equations import NormalEquations, normal_equations
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.state_prior import StatePrior
from tests.hybrid_problems import MEASURED, SENSORS, double_precision, observed_order
from tests.places_problems import (
    NOISE,
    crooked_precision,
    differences,
    measured_channels,
    place_model,
    prior_of,
    random_states,
    residual_modes_of,
)
from tests.test_places import crooked_modes

SAMPLES, WINDOWS, HIDDEN = 12, 3, 2
PLACE = 2 + 4 * HIDDEN  # numbers in the table a place
WEIGHTS = torch.tensor([1.0, 0.3, 2.0], dtype=torch.float64)


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


def nets_only() -> Tensor:
    """Which numbers of the flat table belong to nets, not to springs and dashpots."""
    return (torch.arange(7 * PLACE) % PLACE) >= 2


@dataclass(frozen=True)
class Problem:
    """A model, initial states (window, 8) that are not the best, and channels (window, time, sensor) to explain."""

    model: NeuralModalODE
    z0: Tensor
    data: Tensor

    def equations(self, weights: Tensor = WEIGHTS, windows: slice = slice(None)) -> NormalEquations:
        """What the product says."""
        states = trajectory(self.model, self.z0[windows], SAMPLES)
        seen = self.data[windows][:, :, MEASURED].transpose(0, 1)
        prior = prior_of(self.model)
        return normal_equations(self.model, residual_modes_of(self.model), prior, states.detach(), seen, weights)

    def misfit(self) -> Tensor:
        """Data less channels, in noise deviations (window, time * measured)."""
        seen = (self.data[:, :, MEASURED] / torch.tensor(NOISE)).flatten(1)
        return seen - measured_channels(self.model, self.z0, SAMPLES)

    def jacobians(self) -> tuple[Tensor, Tensor]:
        """B (window, 8, value) by the states and A (window, parameter, value) by the table, by brute force."""
        by_state = differences(lambda z: measured_channels(self.model, z, SAMPLES), self.z0)  # (w, 8, w, value)
        table = residual_modes_of(self.model).table.detach().clone()
        by_table = differences(lambda t: measured_channels(self.model, self.z0, SAMPLES, t), table)
        B = torch.stack([by_state[i, :, i] for i in range(len(self.z0))])
        return B, by_table.flatten(0, 1).transpose(0, 1)


def problem(substeps: int = 1) -> Problem:
    model = place_model(crooked_modes(), hidden=HIDDEN, substeps=substeps)
    generator = torch.Generator().manual_seed(8)
    return Problem(
        model, random_states(WINDOWS), 0.3 * torch.randn(WINDOWS, SAMPLES, len(SENSORS), generator=generator)
    )


def with_prior(given: Problem, precision: Tensor) -> Problem:
    given.model.encoder = StatePrior(precision, torch.tensor(NOISE))
    return given


def schur(given: Problem, precision: Tensor, weights: Tensor = WEIGHTS) -> tuple[Tensor, Tensor]:
    """N and g: the joint normal matrix of [all states, parameters] with all states eliminated at once."""
    B, A = given.jacobians()
    r, parameters, states = given.misfit(), A.shape[1], 8 * WINDOWS
    joint, right = torch.zeros(states + parameters, states + parameters), torch.zeros(states + parameters)
    for i, weight in enumerate(weights):
        J = torch.cat([torch.zeros(states, A.shape[2]), A[i]])
        J[8 * i : 8 * i + 8] = B[i]
        joint += weight * J @ J.T
        right += weight * J @ r[i]
        own = slice(8 * i, 8 * i + 8)
        joint[own, own] += weight * precision
        right[own] -= weight * precision @ given.z0[i]
    M, S = joint[:states, :states], joint[states:, :states]
    solved = torch.linalg.solve(M, torch.cat([S.T, right[:states, None]], dim=1))
    return joint[states:, states:] - S @ solved[:, :-1], right[states:] - S @ solved[:, -1]


def close(found: Tensor, expected: Tensor, share: float = 1e-6) -> None:
    """To a ``share`` of the largest: central differences are good to 1e-9, and products of them add up."""
    torch.testing.assert_close(found, expected, rtol=0, atol=share * float(expected.abs().max()))


@pytest.mark.parametrize("substeps", [1, 2])
def test_they_are_the_schur_complement_of_the_joint_problem(substeps: int) -> None:
    """With the prior on the states, weights, and states that are not yet the best; by all numbers of the nets."""
    given = problem(substeps)
    N, g = schur(given, crooked_precision())
    found, nets = given.equations(), nets_only()
    assert found.matrix.shape == (7 * PLACE, 7 * PLACE)
    close(found.matrix[nets][:, nets], N[nets][:, nets])
    close(found.downhill[nets], g[nets])


def test_springs_and_dashpots_are_right_to_second_order_in_the_step() -> None:
    """They act through the exponential, and count as explicit forces; 0.25: the first step is of first order once."""
    errors, substeps = [], (2, 4, 8)
    linear = ~nets_only()
    for count in substeps:
        given = problem(count)
        N, _ = schur(given, crooked_precision())
        error = given.equations().matrix[linear][:, linear] - N[linear][:, linear]
        errors.append(float(error.abs().max() / N[linear][:, linear].abs().max()))
    assert observed_order([1 / count for count in substeps], errors) == pytest.approx(2.0, abs=0.25), errors


def test_weights_count_windows() -> None:
    """The equations of several windows are the weighted sum of each one's; 1e-12 is rounding."""
    given = problem()
    together = given.equations()
    alone = [given.equations(torch.ones(1), slice(i, i + 1)) for i in range(WINDOWS)]
    pairs = list(zip(WEIGHTS, alone, strict=True))
    close(together.matrix, torch.stack([weight * one.matrix for weight, one in pairs]).sum(dim=0), 1e-12)
    close(together.downhill, torch.stack([weight * one.downhill for weight, one in pairs]).sum(dim=0), 1e-12)
    close(together.coupling, torch.cat([one.coupling for one in alone]), 1e-12)
    close(given.equations(3 * WEIGHTS).matrix, 3 * together.matrix, 1e-12)
    close(given.equations(torch.zeros(WINDOWS)).matrix + 1, torch.ones_like(together.matrix), 1e-12)


def test_a_prior_that_is_certain_holds_the_states_at_zero() -> None:
    """P^-1 = 1e12: the states go to zero, whatever the parameters; N = A A^T, and g knows of that move.

    1e-5: a precision of 1e12 holds the states to 1e-12 times slopes of some 1e5.
    """
    given = with_prior(problem(), 1e12 * torch.eye(8))
    B, A = given.jacobians()
    nets, found = nets_only(), given.equations()
    close(found.own, -given.z0, 1e-5)
    assert float(found.coupling.abs().max()) < 1e-5
    N = torch.einsum("bpt,brt,b->pr", A, A, WEIGHTS)
    moved = given.misfit() + torch.einsum("bst,bs->bt", B, given.z0)
    g = torch.einsum("bpt,bt,b->p", A, moved, WEIGHTS)
    close(found.matrix[nets][:, nets], N[nets][:, nets], 1e-5)
    close(found.downhill[nets], g[nets], 1e-5)


def test_states_follow_the_parameters() -> None:
    """For any change d of the nets, own - coupling d minimises |r - A^T d - B^T e|^2 + |z0 + e|^2 in P^-1.

    As `numpy.linalg.lstsq` solves it, window by window.
    """
    given, nets = problem(), nets_only()
    B, A = given.jacobians()
    found, r = given.equations(), given.misfit()
    d = 0.1 * torch.randn(7 * PLACE, generator=torch.Generator().manual_seed(3)) * nets
    root = torch.linalg.cholesky(crooked_precision()).T
    for i in range(WINDOWS):
        tall = torch.cat([B[i].T, root]).numpy()
        right = torch.cat([r[i] - A[i].T @ d, -root @ given.z0[i]]).numpy()
        expected = np.linalg.lstsq(tall, right, rcond=None)[0]
        close(found.own[i] - found.coupling[i] @ d, torch.tensor(expected))


def test_downhill_is_the_slope_of_what_is_left_once_the_states_are_solved_for() -> None:
    """-g = d/dp of the sum of the least misfits, each window's state solved for anew (the envelope's theorem).

    1e-4: the difference quotient has a step of 1e-4, along directions of 70 numbers near one.
    """
    given = problem()
    prior, residual = prior_of(given.model), residual_modes_of(given.model)

    def least(start: Tensor) -> tuple[Tensor, Tensor]:
        estimate = estimate_state(given.model, prior, given.data, start, iterations=40)
        return estimate.mean, WEIGHTS @ estimate.misfit

    solved, _ = least(given.z0)
    g = replace(given, z0=solved).equations().downhill
    for seed in range(3):
        direction = torch.randn(7 * PLACE, generator=torch.Generator().manual_seed(seed)) * nets_only()
        values = []
        for size in (1e-4, -1e-4):
            with torch.no_grad():
                residual.table.add_(size * direction.view_as(residual.table))
                values.append(float(least(solved)[1]))
                residual.table.sub_(size * direction.view_as(residual.table))
        slope = (values[0] - values[1]) / 2e-4
        assert -float(g @ direction) == pytest.approx(slope, rel=1e-4, abs=1e-5 * float(g.norm() * direction.norm()))


def test_at_rest_and_in_single_precision_they_are_numbers_in_double() -> None:
    model = place_model(hidden=HIDDEN).float()
    states = torch.zeros(SAMPLES, 2, 8, dtype=torch.float32)
    seen = torch.zeros(SAMPLES, 2, 4, dtype=torch.float32)
    found = normal_equations(model, residual_modes_of(model), prior_of(model), states, seen, torch.ones(2).float())
    for part in (found.matrix, found.downhill):
        assert part.dtype == torch.float64
        assert bool(torch.isfinite(part).all())
    assert float(found.downhill.abs().max()) == 0.0
    assert float(found.matrix.abs().max()) == 0.0  # nothing moves: no parameter has any effect
