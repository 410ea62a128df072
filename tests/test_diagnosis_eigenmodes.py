"""Modes of variants that hardly differ, to first order, against those of each by itself."""

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from hybrid.diagnosis.response.config import EIGENMODES
from hybrid.diagnosis.response.eigenmodes import aligned_modes, eigenmodes

SIZE, KEPT = 8, 4


def variants(step: float, twins: float = 0.3) -> tuple[FloatArray, FloatArray]:
    """Return M and K (variant, vector, vector), the first and three a ``step`` from it; two of its modes, ``twins``
    apart, are both among those kept.
    """
    rng = np.random.default_rng(0)
    vectors = np.eye(SIZE) + 0.05 * rng.standard_normal((SIZE, SIZE))  # its first modes stay near the first coordinates
    omega2 = np.array([1.0, 2.0, 2.0 + twins, 4.0, 5.0, 6.5, 8.0, 10.0])
    changes = rng.standard_normal((2, 3, SIZE, SIZE))
    dM, dK = step * (changes + changes.swapaxes(-1, -2))
    M, K = vectors @ vectors.T, vectors @ np.diag(omega2) @ vectors.T
    return np.array([M, *(M + dM)]), np.array([K, *(K + dK)])


def functions(M: FloatArray, K: FloatArray, first_order: bool) -> list[FloatArray]:
    """Return what the modes are used for, whatever their signs: squares of frequencies, a damping, coordinates."""
    modes = eigenmodes(M, K, first_order)
    assert modes.first_order == first_order
    weighted = M @ modes.shapes
    damping = (weighted * np.arange(SIZE)) @ weighted.swapaxes(1, 2)
    return [modes.omega2, damping, aligned_modes(modes, KEPT)]


def test_what_is_left_out_goes_with_the_square_of_the_step() -> None:
    off = []
    for step in (1e-5, 1e-6):
        pairs = zip(*(functions(*variants(step), first_order=near) for near in (True, False)), strict=True)
        off.append([np.abs(near[1:] - exact[1:]).max() for near, exact in pairs])
    np.testing.assert_allclose(np.array(off[0]) / off[1], 100, rtol=0.05)  # of rounding, 1e-14 of 1e-10


def test_modes_of_equal_frequency_mix_however_small_the_step() -> None:
    M, K = variants(1e-7, twins=1e-5)
    near, exact = eigenmodes(M, K, first_order=True), eigenmodes(M, K)
    assert not near.first_order  # the step over the gap is beyond max_mixing
    np.testing.assert_array_equal(near.shapes, exact.shapes)
    np.testing.assert_array_equal(aligned_modes(near, KEPT), aligned_modes(exact, KEPT))
    assert eigenmodes(*variants(1e-7 * EIGENMODES.max_mixing, twins=1e-5), first_order=True).first_order


def test_modes_of_the_same_frequency_are_solved_one_by_one() -> None:
    K = np.diag([1.0, 2.0, 2.0, 3.0]) + np.zeros((2, 1, 1))
    K[1, 1, 2] = K[1, 2, 1] = 1e-6
    found = eigenmodes(np.repeat(np.eye(4)[None], 2, axis=0), K, first_order=True)
    assert not found.first_order
    assert found.omega2[1] == pytest.approx([1, 2 - 1e-6, 2 + 1e-6, 3], rel=1e-12)
