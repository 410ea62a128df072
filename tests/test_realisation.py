"""Eigensystem realisation on exact linear systems, where it must be exact, and beyond, where it must not pretend."""

import numpy as np
import pytest

from fe_models.errors import InputError
from hybrid.identification.realisation import StateSpace, forecast_from_start, realise
from tests.hybrid_problems import OFF_RATIO, STEP, off_chain, recorded

EXACT = 1e-8  # of the largest sample: rounding of the Hankel matrix's SVD, over 60 steps; 1e-11 is reached


def chain_decays(realisations: int, samples: int, seed: int) -> np.ndarray:
    """The four-mass chain's free decays in closed form, five channels of three quantities."""
    return recorded(off_chain(), realisations, samples, seed)


def test_its_poles_are_those_of_the_chain() -> None:
    """Eight: e^{s h} with s = -xi w +- i w sqrt(1 - xi^2), four modes known in closed form."""
    model = realise([chain_decays(3, 80, 1)], order=8, rows=10)
    omega = off_chain().omega
    s = -OFF_RATIO * omega + 1j * omega * np.sqrt(1 - OFF_RATIO**2)
    expected = np.exp(np.concatenate([s, s.conj()]) * STEP)
    found = np.linalg.eigvals(model.transition)
    distances = np.abs(found[:, None] - expected)
    assert distances.min(axis=0).max() < EXACT
    assert distances.min(axis=1).max() < EXACT


def test_it_forecasts_an_exact_linear_system_exactly() -> None:
    """Motions that it never saw, of two recordings of different lengths, from five samples of five channels."""
    model = realise([chain_decays(2, 60, 1), chain_decays(1, 90, 2)], order=8, rows=10)
    unseen = chain_decays(4, 60, 3)
    blind = unseen.copy()
    blind[:, 5:] = np.nan  # nothing after the first samples is looked at
    np.testing.assert_allclose(forecast_from_start(model, blind, 5), unseen, rtol=0, atol=EXACT * np.abs(unseen).max())


def test_states_that_nothing_excites_leave_a_minimum_norm_start() -> None:
    """One sample of five channels tells no eight states: the forecast still goes through that sample."""
    model = realise([chain_decays(3, 80, 1)], order=8, rows=10)
    window = chain_decays(1, 20, 4)
    found = forecast_from_start(model, window, 1)
    np.testing.assert_allclose(found[:, 0], window[:, 0], rtol=0, atol=EXACT * np.abs(window).max())


def test_too_low_an_order_is_not_exact() -> None:
    model = realise([chain_decays(3, 80, 1)], order=6, rows=10)
    unseen = chain_decays(4, 60, 3)
    assert np.abs(forecast_from_start(model, unseen, 5) - unseen).max() > 0.01 * np.abs(unseen).max()


def test_observability_is_the_power_series() -> None:
    model = StateSpace(np.array([[0.5, 1.0], [0.0, 2.0]]), np.array([[1.0, 1.0]]))
    expected = [[[1.0, 1.0]], [[0.5, 3.0]], [[0.25, 6.5]]]  # by hand
    np.testing.assert_array_equal(model.observability(3), expected)


def test_more_states_than_rows_are_refused() -> None:
    with pytest.raises(InputError, match="10 states at most can be estimated from 2 block rows"):
        realise([chain_decays(3, 80, 1)], order=20, rows=2)
