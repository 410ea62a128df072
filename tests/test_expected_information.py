"""Expected information: closed forms of two Gaussians, and its limits."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from hybrid.diagnosis.next_measurement.information import Prediction, distances, least_information, outcome

EVEN = np.array([0.5, 0.5])


def at(*means: float, spread: float = 0.0) -> list[Prediction]:
    """Return predictions of one value; ``spread``: standard deviation beside the noise's own of one."""
    return [Prediction(np.array([mean]), np.array([[spread]])) for mean in means]


def by_quadrature(weights: tuple[float, float], apart: float, wide: float = 1.0) -> tuple[float, float]:
    """Return information (bits) and probability of the likeliest for N(0, 1) and N(apart, wide^2), by integration."""
    densities = (norm(0, 1).pdf, norm(apart, wide).pdf)

    def both(y: float) -> np.ndarray:
        return np.array([w * density(y) for w, density in zip(weights, densities, strict=True)])

    def doubt(y: float) -> float:
        joint = both(y)
        known = joint[joint > 0]
        return float(-np.sum(known * np.log2(known / joint.sum()))) if len(known) else 0.0

    ends = (-10 * wide, apart + 10 * wide)
    left = quad(doubt, *ends, limit=400)[0]
    prior = -sum(w * np.log2(w) for w in weights)
    return prior - left, quad(lambda y: float(both(y).max()), *ends, limit=400)[0]


@pytest.mark.parametrize("count", [2, 3, 5])
def test_hypotheses_that_predict_the_same_are_not_told_apart(count: int) -> None:
    weights = np.full(count, 1 / count)
    same = at(*[0.3] * count, spread=0.5)
    assert least_information(weights, distances(same)) == pytest.approx(0.0, abs=1e-12)
    found = outcome(weights, same, np.random.default_rng(0))
    assert found.information == pytest.approx(0.0, abs=1e-12)
    assert found.probability == pytest.approx(1 / count)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_far_apart_they_are_told_for_sure(count: int) -> None:
    weights = np.full(count, 1 / count)
    far = at(*(60.0 * np.arange(count)))
    assert least_information(weights, distances(far)) == pytest.approx(np.log2(count))
    found = outcome(weights, far, np.random.default_rng(0))
    assert found.information == pytest.approx(np.log2(count))
    assert found.probability == pytest.approx(1.0)


def test_information_grows_with_the_distance_and_bounds_hold() -> None:
    """The closed form stays below the integral, and both rise: by it measurements are ranked."""
    exact = [by_quadrature((0.5, 0.5), apart)[0] for apart in (0.5, 1.0, 2.0, 4.0, 8.0)]
    bound = [least_information(EVEN, distances(at(0.0, apart))) for apart in (0.5, 1.0, 2.0, 4.0, 8.0)]
    assert np.all(np.diff(exact) > 0)
    assert np.all(np.diff(bound) > 0)
    assert np.all(np.array(bound) <= exact)
    assert np.array(bound) == pytest.approx(exact, abs=0.2)  # of one bit: Bhattacharyya's bound is that near


@pytest.mark.parametrize(("weight", "apart"), [(0.5, 2.0), (0.8, 1.5), (0.6, 4.0)])
def test_what_is_drawn_agrees_with_the_integral(weight: float, apart: float) -> None:
    """200 draws tell either to about 0.02: four of these standard deviations."""
    weights = (weight, 1 - weight)
    information, probability = by_quadrature(weights, apart)
    found = outcome(np.array(weights), at(0.0, apart), np.random.default_rng(1))
    assert found.information == pytest.approx(information, abs=0.1)
    assert found.probability == pytest.approx(probability, abs=0.08)


def test_distance_of_unequal_variances_is_bhattacharyyas() -> None:
    one, two = Prediction(np.array([0.0]), np.array([[0.0]])), Prediction(np.array([1.5]), np.array([[2.0]]))
    wide = 1 + 2.0**2
    expected = 0.25 * 1.5**2 / (1 + wide) + 0.5 * np.log((1 + wide) / (2 * np.sqrt(wide)))
    np.testing.assert_allclose(distances([one, two]), [[0, expected], [expected, 0]], atol=1e-12)


def test_what_parameters_may_make_up_for_tells_nothing() -> None:
    """Two means apart along a direction that is open in both; across it the same distance tells."""
    spread = np.array([[100.0], [0.0]])
    origin = Prediction(np.zeros(2), spread)
    along, across = (Prediction(np.array(mean), spread) for mean in ([6.0, 0.0], [0.0, 6.0]))
    told = [least_information(EVEN, distances([origin, other])) for other in (along, across)]
    assert told[0] < 0.01
    assert told[1] > 0.95


def test_recordings_next_to_no_noise_end_in_no_error() -> None:
    """What is open, over noise of a millionth of a millionth: rounding alone would make such a covariance singular."""
    rng = np.random.default_rng(0)
    wide = [Prediction(1e12 * rng.standard_normal(50), 1e12 * rng.standard_normal((50, 30))) for _ in range(2)]
    assert least_information(EVEN, distances(wide)) == pytest.approx(1.0, abs=1e-3)
