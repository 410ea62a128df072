"""Weighted sums over the samples of many channels at once."""

import numpy as np
import pytest
from scipy.signal import convolve

from hybrid.diagnosis.response.filtering import BLOCK_VALUES, convolved


@pytest.mark.parametrize("samples", [40, 3 * BLOCK_VALUES])  # less than a block, and a few
def test_each_channel_is_convolved_with_the_kernel(samples: int) -> None:
    rng = np.random.default_rng(1)
    long, kernel = rng.standard_normal((2, 3, samples, 4)), rng.standard_normal(7)
    found = convolved(long, kernel)
    assert found.shape == (2, 3, samples - 6, 4)
    for index in np.ndindex(2, 3, 4):
        channel = (*index[:2], slice(None), index[2])
        expected = convolve(long[channel], kernel, mode="valid", method="direct")
        np.testing.assert_allclose(found[channel], expected, atol=1e-13)  # sums in another order


def test_channels_in_any_layout_are_convolved() -> None:
    rng = np.random.default_rng(2)
    turned, kernel = rng.standard_normal((3, 50)), rng.standard_normal(5)
    np.testing.assert_array_equal(convolved(turned.T, kernel), convolved(np.ascontiguousarray(turned.T), kernel))


def test_what_is_not_finite_stays_so() -> None:
    long = np.zeros((20, 1))
    long[10] = np.nan
    assert np.isnan(convolved(long, np.ones(3))[8:11]).all()
    assert np.isfinite(convolved(long, np.ones(3))[[7, 11]]).all()
