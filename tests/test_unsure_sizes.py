"""Standard deviations where the sizes of errors are estimated from few modes, and from many."""

import numpy as np
import pytest
from scipy.stats import gamma, multivariate_normal

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.elliptical_slices import slice_samples
from hybrid.diagnosis.modal.error_sizes import LOG_SPREADS, ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit, Start, fit_claim
from hybrid.diagnosis.modal.nominal_fit import null_fit
from hybrid.diagnosis.modal.unsure_sizes import likelihood_of_sizes, posterior_over_sizes, with_unsure_sizes
from tests.test_modal_evidence import chain, dataset, measured_of, modes_of, off, search_of

__all__ = ["dataset"]  # a fixture


def widened(dataset: Dataset, recordings: int) -> tuple[ModalFit, ModalFit]:
    """Return the fit of nothing wrong to so many recordings of a chain that is far off, and that with unsure sizes."""
    rng = np.random.default_rng(3)
    factors = off(rng)
    measured = measured_of(dataset, *(modes_of(chain(factors), f"r{number}", rng) for number in range(recordings)))
    found = null_fit(measured)
    assert found is not None
    return found, with_unsure_sizes(measured, found)


def errors(item: ModalFit) -> FloatArray:
    return np.asarray(np.sqrt(np.diag(item.covariance)))


def test_unsure_sizes_make_values_less_sure_and_move_nothing(dataset: Dataset) -> None:
    found, wider = widened(dataset, 1)
    np.testing.assert_array_equal(wider.theta, found.theta)
    assert np.all(errors(wider) > 0.9 * errors(found))  # 32 draws tell a standard deviation to a tenth
    assert errors(wider)[:5].mean() > 1.1 * errors(found)[:5].mean()
    # no farther than ten times the sizes, as of a prior whose logarithm has a standard deviation of 1.5, would have it
    assert np.all(errors(wider) < np.exp(2 * LOG_SPREADS.max()) * errors(found))


def test_the_same_fit_gives_the_same_bits(dataset: Dataset) -> None:
    _, one = widened(dataset, 1)
    _, other = widened(dataset, 1)
    np.testing.assert_array_equal(one.covariance, other.covariance)


def test_draws_have_the_covariance_that_is_reported(dataset: Dataset) -> None:
    rng = np.random.default_rng(3)
    factors = off(rng)
    measured = measured_of(dataset, modes_of(chain(factors), "r0", rng))
    found = null_fit(measured)
    assert found is not None
    posterior = posterior_over_sizes(measured, found)
    assert posterior is not None
    drawn = posterior.draws(4000, np.random.default_rng(1))
    # 2 %, heavy tails
    np.testing.assert_allclose(drawn.std(axis=0), errors(with_unsure_sizes(measured, found)), rtol=0.1)


@pytest.mark.parametrize("shape", [0.5, 4.0])
def test_draws_follow_a_skewed_density(shape: float) -> None:
    """The logarithm of a gamma variable: its closed form, beside a normal approximation that is none too good."""

    def log_density(logs: FloatArray) -> float:
        return float(np.sum(shape * logs - np.exp(logs)))

    middle = np.full(2, np.log(shape))
    root = np.eye(2) / np.sqrt(shape)  # Laplace's
    draws = slice_samples(log_density, middle, root, 2000, 4, np.random.default_rng(0)).ravel()
    below = gamma(shape).cdf(np.exp(draws))  # even from 0 to 1
    # 4000 draws, of which some hang together: a share is known to 0.01; three of these
    for share in (0.05, 0.25, 0.5, 0.75, 0.95):
        assert np.mean(below < share) == pytest.approx(share, abs=0.03)


def test_sizes_are_as_likely_as_they_are_beside_any_value_of_the_cause(dataset: Dataset) -> None:
    """The normal density of all that is measured, the cause's value as uncertain as before."""
    rng = np.random.default_rng(4)
    measured = measured_of(dataset, modes_of(chain(), "r0", rng))
    mass = next(own for own in search_of(dataset, measured).candidates if own.kind == "added_mass")
    null = null_fit(measured)
    assert null is not None
    claim = Claim(measured.null.hypothesis.adding(mass), ((0,),))
    item = fit_claim(measured, Start(claim, np.append(null.theta, 0.02 * mass.width[0]), null.sizes))
    assert item is not None
    width, centre = claim.hypothesis.width[-1], claim.hypothesis.centre[-1]
    for sizes in (item.sizes, ErrorSizes(), ErrorSizes(mass_scale=4.0)):
        moved = item.slopes[:, -1] * width
        covariance = item.rows.covariance(sizes) + np.outer(moved, moved)
        at_centre = item.residual + item.slopes[:, -1] * (item.theta[-1] - centre)
        expected = multivariate_normal(cov=covariance, allow_singular=True).logpdf(at_centre)
        assert likelihood_of_sizes(item).value(sizes) == pytest.approx(expected, rel=1e-6)
