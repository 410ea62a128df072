"""Evidence over time: modes under forces, the filter and what it marginalises, held against dense algebra."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag, expm
from scipy.stats import multivariate_normal

from fe_models.arrays import FloatArray
from hybrid.diagnosis.discrepancy.config import DISCREPANCY
from hybrid.diagnosis.discrepancy.expected_modes import Expectation, ExpectedModes, slopes_over_time
from hybrid.diagnosis.discrepancy.kalman import filtered, unexpected
from hybrid.diagnosis.discrepancy.law_forces import DirectForce
from hybrid.diagnosis.discrepancy.linearisation import linearised, unforced
from hybrid.diagnosis.discrepancy.marginal import Marginal
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace, amplitude_of
from hybrid.diagnosis.discrepancy.size import right_law_probability, usual_probability

STEP = 0.05
RNG = np.random.default_rng(5)


def space_of(omega: tuple[float, ...] = (3.0, 7.0), ratio: float = 0.02) -> ModalSpace:
    """Two modes of two masses, a displacement and an acceleration measured."""
    shapes = np.array([[0.6, 0.8], [0.8, -0.6]])[:, : len(omega)]
    frequency, damping = np.array(omega), np.full(len(omega), ratio)
    roots = frequency * (-damping + 1j * np.sqrt(1 - damping**2))
    shown = np.stack([shapes[0] + 0j, shapes[1] * roots**2])
    return ModalSpace(frequency, damping, shapes, shown, np.eye(2), np.array([False, True]), STEP)


def matrices(space: ModalSpace) -> tuple[FloatArray, FloatArray]:
    """A and C in continuous time, q first, then q'."""
    n = space.count
    A = np.zeros((2 * n, 2 * n))
    A[:n, n:] = np.eye(n)
    A[n:, :n], A[n:, n:] = -np.diag(space.omega**2), -np.diag(2 * space.ratio * space.omega)
    C = np.zeros((2, 2 * n))
    C[0, :n], C[1] = space.shapes[0], space.shapes[1] @ A[n:]
    return A, C


def test_transition_and_output_are_those_of_the_equations_of_motion() -> None:
    space = space_of()
    A, C = matrices(space)
    assert np.allclose(space.whole_transition, expm(A * STEP), atol=1e-12)
    assert np.allclose(space.output, C, atol=1e-12)


def test_force_moves_modes_as_an_ode_solver_says() -> None:
    """A force that a cubic polynomial describes in each step is integrated by Simpson's rule to its fifth order."""
    space, pull = space_of(), np.array([0.0, 1.0])
    A, _ = matrices(space)
    push = np.concatenate([np.zeros(2), pull @ space.shapes])
    times = STEP / DISCREPANCY.parts * np.arange(80 * DISCREPANCY.parts + 1)
    driven = space.pushed(np.sin(2.2 * times), pull)
    states = space.motion(driven.states)
    known = solve_ivp(
        lambda t, x: A @ x + push * np.sin(2.2 * t), (0, times[-1]), np.zeros(4), rtol=1e-10, atol=1e-12, t_eval=times
    )
    assert np.allclose(states, known.y.T[:: DISCREPANCY.parts], atol=2e-6)  # (7 x 0.0125)^4 of amplitudes near 0.1
    shown = states @ space.output.T + driven.channels
    acceleration = space.shapes[1] @ (A[2:] @ known.y + np.outer(push[2:], np.sin(2.2 * times)))
    assert np.allclose(shown[:, 1], acceleration[:: DISCREPANCY.parts], atol=2e-4)


def dense(
    space: ModalSpace, samples: int, pushes: float, noise: FloatArray, begin: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Covariance of all states with all samples, one behind the other, and of these."""
    A, C, n = space.whole_transition, space.output, space.count
    Q = np.block(
        [
            [np.eye(n) * pushes * STEP**2 / 3, np.eye(n) * pushes * STEP / 2],
            [np.eye(n) * pushes * STEP / 2, np.eye(n) * pushes],
        ]
    )
    P, whole = [np.diag(begin)], np.zeros((samples * 2 * n, samples * 2 * n))
    for _ in range(samples - 1):
        P.append(A @ P[-1] @ A.T + Q)
    for i in range(samples):
        part = P[i]
        for j in range(i, samples):
            rows, columns = slice(2 * n * j, 2 * n * (j + 1)), slice(2 * n * i, 2 * n * (i + 1))
            whole[rows, columns] = part
            whole[columns, rows] = part.T
            part = A @ part
    every = block_diag(*[C] * samples)
    return whole @ every.T, every @ whole @ every.T + np.diag(np.tile(noise, samples))


FollowedMotion = tuple[ModalSpace, FloatArray, FloatArray, FloatArray, float]


@pytest.fixture(name="followed")
def _followed() -> FollowedMotion:
    space, noise, begin = space_of(), np.array([0.01, 0.3]), np.array([1.0, 0.5, 4.0, 9.0])
    return space, RNG.standard_normal((25, 2)), noise, begin, 0.04


@pytest.mark.slow
def test_filter_is_the_normal_distribution_of_all_samples(followed: FollowedMotion) -> None:
    space, data, noise, begin, push = followed
    found = filtered(unforced(space, 25), data, noise, np.full((25, 2), push), begin, STEP)
    with_states, covariance = dense(space, 25, push, noise, begin)
    density = multivariate_normal(np.zeros(50), covariance).logpdf(data.ravel())
    own = -0.5 * np.sum(found.white**2) + found.log_scale - 25 * np.log(2 * np.pi)
    assert own == pytest.approx(density, abs=1e-6)  # 50 values, as far as a Cholesky factor is exact
    states = with_states @ np.linalg.solve(covariance, data.ravel())
    assert np.allclose(found.states.ravel(), states, atol=1e-8)


def test_what_is_unexpected_is_what_more_data_would_bring(followed: FollowedMotion) -> None:
    space, data, noise, begin, push = followed
    pushes = np.full((25, 2), push)
    added, shown = RNG.standard_normal((25, 4)), RNG.standard_normal((25, 2))
    before = filtered(unforced(space, 25), data, noise, pushes, begin, STEP)
    more = data + space.motion(added) @ space.output.T + shown
    after = filtered(unforced(space, 25), more, noise, pushes, begin, STEP)
    assert np.allclose(after.white - before.white, unexpected(before, added[None], shown[None])[0], atol=1e-9)


def test_slopes_are_those_of_a_filter_whose_modes_are_off() -> None:
    """Of data without noise that the modes explain: a value that is off by 1e-5 is unexpected as its slope says."""
    space = space_of()
    states = np.array([np.linalg.matrix_power(space.whole_transition, t) @ [1.0, 0.5, 0.2, -2.0] for t in range(200)])
    data, noise, pushes = states @ space.output.T, np.array([1e-4, 1e-2]), np.full((200, 2), 1e-8)
    begin = np.full(4, 100.0)
    known = filtered(unforced(space, 200), data, noise, pushes, begin, STEP)
    modes = ExpectedModes(space, np.array([0, 0]), np.zeros((8, 1)), np.zeros(8))
    slopes = unexpected(known, *slopes_over_time(modes, known.states, space.fine_motion(known.states), 1))
    off = 1e-5
    for number, other in (
        (0, replace(space, omega=space.omega * np.exp([0.0, -off]))),
        (1, replace(space, ratio=space.ratio - np.array([0.0, off]))),
        (2, replace(space, shown=space.shown - off * np.outer([0, 1], [0, space.shown[0, 1]]))),
    ):
        before = filtered(unforced(other, 200), data, noise, pushes, begin, STEP)
        change = (before.white - known.white) / off
        assert np.allclose(slopes[number], change, atol=2e-3 * np.abs(change).max())  # what is of second order


def test_marginal_is_the_normal_distribution_of_residuals() -> None:
    slopes = [RNG.standard_normal((30, 3)) for _ in range(2)]
    J = RNG.standard_normal((3, 2))
    modes = tuple(ExpectedModes(space_of(), np.array([0, 0]), J, np.zeros(3)) for _ in range(2))
    expected = Expectation(
        modes, np.array([0.3, -0.2]), np.array([0.5, 1.5]), np.array([0.1, 0.2, 0.3]), np.array([0.4, 0.1, 0.2])
    )
    marginal, residuals = Marginal.of(slopes, expected), [RNG.standard_normal(30) for _ in range(2)]
    common = J @ np.diag(expected.spread**2) @ J.T + np.diag(expected.common**2)
    N = block_diag(*slopes)
    prior = np.kron(np.ones((2, 2)), common) + np.kron(np.eye(2), np.diag(expected.vary**2))
    covariance = np.eye(60) + N @ prior @ N.T
    mean = N @ np.tile(J @ expected.shift, 2)
    density = multivariate_normal(mean, covariance).logpdf(np.concatenate(residuals)) + 30 * np.log(2 * np.pi)
    centred = marginal.centred(residuals)
    assert marginal.log_density(centred) == pytest.approx(density, abs=1e-8)
    inverse = np.linalg.solve(covariance, np.concatenate(centred))
    assert np.allclose(np.concatenate(marginal.weighed(centred)), inverse, atol=1e-9)


def test_linearised_motion_follows_a_cubic_spring_as_an_ode_solver_does() -> None:
    """About the solver's own motion nothing is left but the step's error, and small changes go by the tangent."""
    space, pull = space_of(), np.array([1.0, 0.0])
    A, _ = matrices(space)
    push = np.concatenate([np.zeros(2), pull @ space.shapes])

    def force(u: FloatArray, v: FloatArray) -> FloatArray:
        return 20.0 * u**3

    def rate(t: float, x: FloatArray) -> FloatArray:
        return A @ x - push * 20.0 * (pull @ space.shapes @ x[:2]) ** 3

    times = STEP * np.arange(100)
    begun = np.array([0.3, 0.1, 0.0, 0.5])
    runs = [
        solve_ivp(rate, (0, times[-1]), start, rtol=1e-10, atol=1e-12, t_eval=times).y.T
        for start in (begun, begun + 1e-4)
    ]
    motion = linearised(space, runs[0], [DirectForce(pull, force)])
    assert np.abs(motion.drift).max() < 2e-3 * np.abs(runs[0]).max()  # states within a step are weighed, not solved for
    beside = runs[1] - runs[0]
    ahead = np.einsum("tij,tj->ti", motion.transition[:-1], beside[:-1])
    assert np.allclose(ahead, beside[1:], atol=5e-3 * np.abs(beside).max())
    free = np.einsum("ij,tj->ti", space.whole_transition, beside[:-1])
    assert np.abs(free - beside[1:]).max() > 10 * np.abs(ahead - beside[1:]).max()  # the tangent is what does it


def test_amplitude_makes_the_motion() -> None:
    root = np.array([-0.1 + 3.0j])
    motion = (0.3 - 0.4j) * np.exp(root[0] * np.arange(3) * 0.2)
    of_q, of_rate = amplitude_of(root)
    assert np.allclose(of_q[0] * motion.real + of_rate[0] * (root[0] * motion).real, motion)


def test_law_that_leaves_what_right_models_leave_is_right() -> None:
    usual = DISCREPANCY.usual_size
    assert right_law_probability(50 * usual, usual) > 0.99
    assert right_law_probability(50 * usual, 40 * usual) < 0.1
    assert usual_probability(usual / 10) == 1.0
    assert usual_probability(50 * usual) < 0.05
