"""The modes that a simulation in steps shows, against the steps themselves."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import TimeIntegration
from fe_models.causes.time_integration import root
from fe_models.damping import full_damping
from fe_models.modes import natural_modes
from fe_models.structure import Damping
from tests.problems import newmark


@pytest.mark.parametrize("step", [0.05, 0.4, 1.5])
@pytest.mark.parametrize("ratio", [0.0, 0.03])
def test_newmark_steps_are_the_exact_motion_of_the_modes_shown(step: float, ratio: float) -> None:
    chain = replace(four_dof(), dashpots=(), damping=Damping(modal_ratios=(ratio,)))
    model = linearise(chain)
    modal = natural_modes(model, 4)
    start = np.array([1.0, -0.6, 0.8, 0.5])
    matrices = model.mass.toarray(), full_damping(model), model.stiffness.toarray()
    steps = newmark(matrices, start, step, 200)
    exact = root(modal.omega, modal.damping_ratio)
    seen = root(*TimeIntegration(step).frequency_and_ratio(modal.omega, modal.damping_ratio))
    t = step * np.arange(201)[:, None]
    # From rest: q0 = a + a*, 0 = lambda a + lambda* a*, whose velocity is that of the exact mode.
    a = (modal.shapes.T @ matrices[0] @ start) * exact.conj() / (exact.conj() - exact)
    q = 2 * (a * np.exp(seen * t)).real
    np.testing.assert_allclose(q @ modal.shapes.T, steps, atol=1e-9)  # rounding in 200 steps


def test_periods_are_longer_by_the_textbook_s_share() -> None:
    """Without damping 2 atan(h w / 2) / h: the period is longer by (h w)^2 / 12, of order 2 in the step."""
    omega = np.array([1.0, 2.0])
    shown, ratio = TimeIntegration(0.1).frequency_and_ratio(omega, np.zeros(2))
    np.testing.assert_allclose(shown, 2 / 0.1 * np.arctan(0.05 * omega), rtol=1e-14)
    np.testing.assert_allclose(omega / shown - 1, (0.1 * omega) ** 2 / 12, rtol=5e-3)  # next term: a tenth of (h w)^2
    np.testing.assert_allclose(ratio, 0.0, atol=1e-15)
    tiny, _ = TimeIntegration(1e-9).frequency_and_ratio(omega, np.zeros(2))
    np.testing.assert_allclose(tiny, omega, rtol=1e-14)


@pytest.mark.parametrize("step", [0.0, -1.0, float("inf"), float("nan")])
def test_a_step_must_be_one(step: float) -> None:
    assert TimeIntegration(step).faults() == [f"step = {step} s; must be positive"]
