"""Standard deviations where the sizes of errors are estimated from few modes, and from many."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from hybrid.diagnosis.modal.error_sizes import LOG_SPREADS
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.nominal_fit import null_fit
from hybrid.diagnosis.modal.unsure_sizes import posterior_over_sizes, with_unsure_sizes
from tests.test_modal_evidence import chain, dataset, measured_of, modes_of, off

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
    np.testing.assert_allclose(
        drawn.std(axis=0), errors(with_unsure_sizes(measured, found)), rtol=0.1
    )  # 2 %, heavy tails
