"""What a model lacks counts as noise where it is far more than that, and only there."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.causes.candidate import HarmonicCandidate
from fe_models.causes.places import Motion
from hybrid.diagnosis.contest.discrepancy import energy_over, in_units_of, repeated, search_noise_model
from hybrid.diagnosis.contest.evidence import Evidence
from hybrid.diagnosis.contest.growing import lengths_of, short_fit
from hybrid.diagnosis.contest.posterior import posterior_of
from hybrid.diagnosis.fitting.harmonic_amplitude import harmonic_amplitude
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.batches import batches_of, columns_of, measured_columns
from hybrid.diagnosis.recorded.noise import noise_of_recordings, structure_band
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis


def test_noise_repeats_nothing_and_a_tone_does() -> None:
    rng = np.random.default_rng(0)
    assert repeated((rng.standard_normal((4, 1000, 3)),)) < 1.2  # 333 lags, each with a rho^2 of 1 / 12000
    time = np.arange(1000)[:, None]
    tone = np.cos(0.3 * time)[None] * np.ones((1, 1, 3))
    # rho = (1 - k / 1000) cos(0.3 k): the sum of its squares over 333 lags is half of that of (1 - k / 1000)^2
    expected = 1 + np.sum((1 - np.arange(1, 333) / 1000) ** 2)
    assert abs(repeated((tone,)) - expected) < 0.05 * expected


def test_noise_stays_where_noise_counts_and_grows_where_the_model_is_far_off() -> None:
    case = blind_case(5, BlindConfig(("stiffness_change",), size=1.0, train=3, test=1, duration=30.0))
    dataset = case.dataset
    nominal, measured = nominal_model_of(dataset), measured_columns(dataset)
    batches = columns_of(batches_of(dataset, "train"), measured)
    band = structure_band(nominal, dataset.sampling_rate)
    sigma = noise_of_recordings(batches, dataset.sampling_rate, band)
    noise_model = NoiseModel(tuple(dataset.sensors[i] for i in measured), dataset.sampling_rate, sigma)
    lengths = lengths_of(batches, Hypothesis(nominal).states)
    short = short_fit(nominal, lengths, noise_model)
    assert search_noise_model(nominal, lengths, noise_model, short) == (noise_model, lengths, short)
    # as if the sensors had hardly any noise, and the model were as wrong
    cleaner = replace(noise_model, sigma=sigma / 1000)
    begun = short_fit(nominal, lengths, cleaner)
    searched, _, found = search_noise_model(nominal, lengths, cleaner, begun)
    assert np.all(searched.sigma > 100 * cleaner.sigma)
    # what is known of the springs counts again: they stay nearer to what their owner knows
    assert np.abs(found.theta / nominal.spread).max() < 0.5 * np.abs(begun.theta / nominal.spread).max()
    back = in_units_of(cleaner, found, searched)
    np.testing.assert_allclose(back.chi2, found.chi2 * (searched.sigma[0] / cleaner.sigma[0]) ** 2, rtol=1e-9)
    assert np.isclose(back.cost - back.chi2, found.cost - found.chi2, rtol=1e-6, atol=1e-3)


def test_forces_are_judged_alike_in_either_unit() -> None:
    """How large a harmonic force is and where it acts does not depend on the unit in which what is left is counted."""
    dataset = blind_case(2).dataset
    nominal, measured = nominal_model_of(dataset), measured_columns(dataset)
    batches = columns_of(batches_of(dataset, "train"), measured)
    noise_model = NoiseModel(
        tuple(dataset.sensors[i] for i in measured), dataset.sampling_rate, np.full(len(measured), 0.03)
    )
    searched = replace(noise_model, sigma=10 * noise_model.sigma)
    candidates = all_candidates(nominal, dataset, Motion(np.eye(4), np.eye(4)), measured)
    force = next(candidate for candidate in candidates if isinstance(candidate, HarmonicCandidate))
    hypothesis = Hypothesis(nominal).adding(force)
    found = fit(hypothesis, np.append(np.zeros(len(nominal.spread)), 0.3), batches, searched)
    assert found is not None
    rescaled = in_units_of(noise_model, found, searched)
    assert np.isclose(energy_over(noise_model, searched), 100.0)
    assert np.isclose(rescaled.chi2, 100.0 * found.chi2)
    before, after = harmonic_amplitude(found, 0), harmonic_amplitude(rescaled, 0)
    assert (before.amplitude, before.error) == (after.amplitude, after.error)
    np.testing.assert_array_equal(before.acting, after.acting)


def test_some_of_the_fits_are_as_probable_among_themselves_as_among_all() -> None:
    """Though these are given in units of the recordings' noise, in which the prior would hardly count."""
    case = blind_case(5, BlindConfig(("stiffness_change",), size=0.3, train=3, test=1, duration=30.0))
    dataset = case.dataset
    nominal, measured = nominal_model_of(dataset), measured_columns(dataset)
    batches = columns_of(batches_of(dataset, "train"), measured)
    noise_model = NoiseModel(
        tuple(dataset.sensors[i] for i in measured), dataset.sampling_rate, np.full(len(measured), 0.003)
    )
    searched = replace(noise_model, sigma=100 * noise_model.sigma)
    candidates = all_candidates(nominal, dataset, Motion(np.eye(4), np.eye(4)), measured)
    springs = [candidate for candidate in candidates if candidate.kind == "stiffness_change"][:4]
    hypotheses = [Hypothesis(nominal), *(Hypothesis(nominal).adding(spring) for spring in springs)]
    fits = [fit(h, h.centre, batches, searched) for h in hypotheses]
    known = tuple(item for item in fits if item is not None)
    whole = posterior_of(known, candidates, is_astray=True)
    rescaled = replace(whole, fits=tuple(in_units_of(noise_model, item, searched) for item in whole.fits))
    evidence = Evidence(in_units_of(noise_model, known[0], searched), rescaled, noise_model, searched, candidates)
    again = evidence.among(rescaled.fits)
    assert again.temper == pytest.approx(whole.temper)
    np.testing.assert_allclose(again.probability, whole.probability)
    np.testing.assert_allclose([item.cost for item in again.fits], [item.cost for item in rescaled.fits])
