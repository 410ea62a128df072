"""Hysteretic springs along motions that a filter knows: what they remember, to first order, and how motion goes on."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fe_models.arrays import FloatArray
from fe_models.causes import HystereticSpring
from hybrid.diagnosis.discrepancy.hysteresis import Hysteresis
from hybrid.diagnosis.discrepancy.kalman import filtered
from hybrid.diagnosis.discrepancy.law_forces import RememberedForce
from hybrid.diagnosis.discrepancy.linearisation import linearised, pushed_by, unforced
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace
from hybrid.diagnosis.discrepancy.remembered_motion import moved_on
from tests.test_discrepancy import STEP, matrices, space_of

PULL = np.array([1.0, 0.0])
BEGUN = np.array([0.3, 0.1, 0.0, 0.5])
SAMPLES = 100


def spring_of(sharpness: float) -> HystereticSpring:
    """One whose reach the motion exceeds several times."""
    return HystereticSpring((1,), "x", 20.0, 1.0, sharpness)


def solved(space: ModalSpace, spring: HystereticSpring, begun: FloatArray) -> FloatArray:
    """States and z (time, 5) from a solver of ordinary differential equations."""
    A, along = matrices(space)[0], PULL @ space.shapes
    push = np.concatenate([np.zeros(2), along])

    def rate(_: float, x: FloatArray) -> FloatArray:
        return np.append(A @ x[:4] - push * spring.force_of(x[4]), spring.rate(along @ x[2:4], x[4]))

    start, times = np.append(begun, spring.pulled_to(along @ begun[:2])), STEP * np.arange(SAMPLES)
    return solve_ivp(rate, (0, times[-1]), start, rtol=1e-9, atol=1e-11, t_eval=times, max_step=5e-3).y.T


@pytest.mark.parametrize("sharpness", [1.0, 2.0, 8.0])
def test_what_is_remembered_is_that_of_an_ode_solver(sharpness: float) -> None:
    spring, time = spring_of(sharpness), np.linspace(0.0, 10.0, 1001)
    u = 0.2 * np.cos(time) * np.exp(-0.05 * time) + 0.05 * np.sin(3.3 * time)

    def rate(t: float, z: FloatArray) -> list[float]:
        v = -0.2 * np.exp(-0.05 * t) * (np.sin(t) + 0.05 * np.cos(t)) + 0.165 * np.cos(3.3 * t)
        return [float(spring.rate(v, z[0]))]

    begun = [float(spring.pulled_to(u[0]))]
    exact = solve_ivp(rate, (0, 10), begun, t_eval=time, rtol=1e-8, atol=1e-10, max_step=5e-3).y[0]
    found = Hysteresis(spring).along(u).z
    # Turns fall between samples: u is off by a h^2 / 8 = 1e-5 m there, of a reach of 0.05 m.
    assert np.abs(found - exact).max() < 2e-3 * spring.reach
    assert np.abs(exact).max() > 0.9 * spring.reach


@pytest.mark.parametrize("sharpness", [1.0, 2.0, 8.0])
def test_linearised_motion_follows_as_an_ode_solver_does(sharpness: float) -> None:
    """About the solver's own motion nothing is left but the step's error; small changes go by the tangent."""
    space, spring = space_of(), spring_of(sharpness)
    first, other = solved(space, spring, BEGUN), solved(space, spring, BEGUN + 1e-4)
    motion = linearised(space, first[:, :4], [RememberedForce(PULL, Hysteresis(spring))])
    assert np.abs(motion.drift).max() < 2e-3 * np.abs(first[:, :4]).max()
    beside = other - first
    ahead = np.einsum("tij,tj->ti", motion.transition[:-1], beside[:-1])
    largest = np.abs(beside).max(axis=0)
    assert (np.abs(ahead - beside[1:]).max(axis=0) < 0.06 * largest).all()  # of z, at turns
    assert (np.abs(ahead - beside[1:]).max(axis=0)[:4] < 6e-3 * largest[:4]).all()
    free = np.einsum("ij,tj->ti", space.whole_transition, beside[:-1, :4])
    assert (np.abs(free - beside[1:, :4]).max(axis=0)[2:] > 0.03 * largest[2:4]).all()  # the tangent is what does it


@pytest.mark.slow
def test_a_filter_finds_the_motion_under_a_spring_that_slides() -> None:
    """From the motion that it takes without the spring, in a few turns, to a fifth of that error."""
    space, spring = space_of(), spring_of(2.0)
    exact, law = solved(space, spring, BEGUN), RememberedForce(PULL, Hysteresis(spring))
    push = pushed_by(law, space, space.fine_motion(exact[:, :4]))
    data = exact[:, :4] @ space.output.T + push.channels
    noise = np.full(data.shape[1], (1e-3 * data.std()) ** 2)
    pushes, begin = np.full((SAMPLES, 2), 1e-8), np.ones(4)
    plain = filtered(unforced(space, SAMPLES), data, noise, 1e4 * pushes, begin, STEP)
    known = plain
    for _ in range(4):
        known = filtered(linearised(space, known.states, [law]), data, noise, pushes, begin, STEP)
    errors = [np.abs(item.states - exact[:, :4]).max(axis=0) for item in (plain, known)]
    assert (errors[1] < 0.2 * errors[0]).all()
    assert (errors[1] < 0.01 * np.abs(exact[:, :4]).max(axis=0)).all()


@pytest.mark.parametrize("sharpness", [1.0, 8.0])
def test_motion_goes_on_as_an_ode_solver_says(sharpness: float) -> None:
    space, spring = space_of(), spring_of(sharpness)
    exact = solved(space, spring, BEGUN)
    states, force = moved_on(RememberedForce(PULL, Hysteresis(spring)), space, exact[:20, :4], SAMPLES)
    # Order 2 in a quarter of a step, and turns within it.
    np.testing.assert_allclose(states, exact[:, :4], atol=5e-3 * np.abs(exact[:, :4]).max())
    np.testing.assert_allclose(force, -spring.force_of(exact[:, 4]), atol=0.03 * spring.slip)
