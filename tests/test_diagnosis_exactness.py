"""How exact nominal values are: Gaussian closed forms, fits made anew, chains as drawn and off."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from benchmarks.blind_cases import SENSORS, BlindConfig, Tier, blind_case
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import AddedMass
from fe_models.recordings import Dataset, Recording
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.diagnosis.contest.exactness import SCALES, tightened
from hybrid.diagnosis.contest.posterior import posterior_of
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.response.hypothesis import Hypothesis
from tests.chain_fits import RATE, candidate, gauge_of, nominal_fit


def chain(tier: Tier) -> Dataset:
    return blind_case(5, BlindConfig(tier=tier, train=3, test=1, duration=30.0)).dataset


def linear_fit(hypothesis: Hypothesis, J: np.ndarray, y: np.ndarray) -> Fit:
    """The least squares of y = J (theta - centre) + white noise, with the hypothesis' prior: exact."""
    precision = np.diag(hypothesis.precision)
    covariance = np.linalg.inv(J.T @ J + precision)
    step = covariance @ J.T @ y
    chi2 = float(np.square(y - J @ step).sum())
    cost = chi2 + float(step @ precision @ step)
    return Fit(hypothesis, hypothesis.centre + step, covariance, chi2, cost, (), (), (), (), ())


def marginal(hypothesis: Hypothesis, J: np.ndarray, y: np.ndarray, scale: float) -> float:
    """The log density of y, theta integrated out; nominal values are uncertain by ``scale`` times what was stated."""
    width = hypothesis.precision**-0.5
    width[: hypothesis.nominal.values] *= scale
    return float(multivariate_normal(cov=np.eye(len(y)) + (J * width**2) @ J.T).logpdf(y))


@pytest.mark.parametrize("scale", SCALES)
def test_a_linear_model_has_its_closed_form(scale: float) -> None:
    """Evidence at one scale over that at another is that of the data's own normal distribution."""
    dataset = chain("exact")
    hypothesis = Hypothesis(nominal_model_of(dataset)).adding(candidate(dataset, "added_mass", node=2))
    rng = np.random.default_rng(1)
    J = rng.standard_normal((40, len(hypothesis.centre))) * hypothesis.precision**0.5 * rng.uniform(0, 3, 40)[:, None]
    y = 3 * rng.standard_normal(40)
    found = tightened(linear_fit(hypothesis, J, y), scale)
    gained = found.narrowed + found.volume - 0.5 * found.rise
    expected = marginal(hypothesis, J, y, scale) - marginal(hypothesis, J, y, 1.0)
    assert gained == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_the_rise_of_the_cost_is_that_of_a_fit_made_anew() -> None:
    """With a quarter of what is stated; 3 %: nominal values off by some per cent act nearly linearly."""
    dataset = chain("off")
    batches, noise_model = gauge_of(dataset)
    wide = nominal_fit(dataset, batches, noise_model)
    stated = dataset.assumptions.uncertainty
    quarter = replace(stated, stiffness=stated.stiffness / 4, mass=stated.mass / 4, damping=stated.damping / 4)
    sure = replace(dataset, assumptions=replace(dataset.assumptions, uncertainty=quarter))
    narrow = nominal_fit(sure, batches, noise_model)
    assert narrow.cost - wide.cost > 10
    assert tightened(wide, 0.25).rise == pytest.approx(narrow.cost - wide.cost, rel=0.03)


@pytest.mark.parametrize(("tier", "scale"), [("off", SCALES[0]), ("exact", SCALES[-1])])
def test_recordings_tell_whether_a_structure_is_as_drawn(tier: Tier, scale: float) -> None:
    dataset = chain(tier)
    base = nominal_fit(dataset, *gauge_of(dataset))
    evidence = [found.volume - 0.5 * found.rise for found in (tightened(base, scale) for scale in SCALES)]
    assert SCALES[int(np.argmax(evidence))] == scale


def heavier(share: float) -> Dataset:
    """The chain as drawn but for mass 2, as Exudyn has it, from three starts, with noise of 3 % of each channel."""
    rng = np.random.default_rng(7)
    chain = four_dof().with_effects(AddedMass(2, 2.0 * share))
    start, rates = rng.standard_normal((2, 3, 4))
    motion = simulate_free(chain, start, rates, FreeConfig(30.0, RATE, 0.01), progress=False)
    sensors = tuple(sensor for sensor in SENSORS if sensor.role == "measured")
    clean = np.stack([motion.shown(s) for s in sensors], axis=-1)
    noise = 0.03 * clean.std(axis=(0, 1)) * rng.standard_normal(clean.shape)
    return Dataset(four_dof(), RATE, sensors, (Recording("r", clean + noise),))


def test_a_structure_as_drawn_tells_a_cause_from_what_is_normal() -> None:
    """A mass that is 1 % too large is one deviation off, which is normal: not so where all else is as drawn."""
    dataset = heavier(0.01)
    batches, noise_model = gauge_of(dataset)
    base, cause = nominal_fit(dataset, batches, noise_model), candidate(dataset, "added_mass", node=2)
    found = fit(base.hypothesis.adding(cause), np.append(base.theta, 0.0), batches, noise_model)
    assert found is not None
    assert found.theta[-1] == pytest.approx(0.02, abs=0.005)
    stated = posterior_of((base, found), (cause,), is_astray=True)
    judged = posterior_of((base, found), (cause,))
    assert stated.fits[0] is base
    assert stated.probability[0] > 0.9
    assert judged.fits[0] is found
    assert judged.probability[0] > 0.99
