"""The damping that all searches share, and the observability matrix by doubling."""

from itertools import islice

import numpy as np
import torch

from hybrid.levenberg_marquardt import Damping
from hybrid.observability import observability_by_doubling


def test_damping_grows_while_steps_fail_and_falls_after_one_that_leads_down() -> None:
    damping = Damping(first=0.01, easing=5.0, tightening=8.0, most=1.0)
    assert list(damping.tries(0.01)) == [0.01, 0.08, 0.64]
    assert damping.eased(0.64) == 0.128
    assert damping.start == 0.01


def test_free_steps_come_first_and_again_once_damping_is_small() -> None:
    damping = Damping(first=0.01, easing=10.0, tightening=10.0, free=1e-10)
    assert list(islice(damping.tries(damping.start), 3)) == [1e-10, 0.01, 0.1]
    assert damping.eased(0.1) == 0.01
    assert damping.eased(0.01) == 1e-10


def test_searches_side_by_side_are_damped_each_by_itself() -> None:
    damping = Damping(first=0.01, easing=5.0, tightening=8.0)
    before, better = np.array([0.1, 0.1]), np.array([True, False])
    expected = [damping.eased(0.1), damping.tightened(0.1)]
    assert damping.after(before, better).tolist() == expected
    assert damping.after(torch.tensor(before), torch.tensor(better)).tolist() == expected


def test_observability_by_doubling_is_that_of_one_power_after_the_other() -> None:
    rng = np.random.default_rng(0)
    C, A = rng.standard_normal((2, 3, 4)), 0.5 * rng.standard_normal((2, 4, 4))
    exact = np.stack([C @ np.linalg.matrix_power(A, k) for k in range(7)], axis=1)  # (variant, time, sensor, state)
    found = observability_by_doubling(C[:, None], A[:, None], 7, np.concatenate)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-13 * np.abs(exact).max())  # rounding of few products
    torched = observability_by_doubling(torch.tensor(C[0][None]), torch.tensor(A[0]), 7, torch.concatenate)
    np.testing.assert_allclose(torched.numpy(), exact[0], rtol=0, atol=1e-13 * np.abs(exact).max())
