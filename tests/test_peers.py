"""The peers of the diagnosis: exhaustive selection by AIC, and sparse regression on learned forces."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.judging import key_of
from benchmarks.blind_cases import BlindCase, BlindConfig, blind_case
from benchmarks.peers.certain import certain_of
from benchmarks.peers.exhaustive import aic_of, name_by_aic
from benchmarks.peers.latent_forces import latent_forces
from benchmarks.peers.sparse import library, name_by_regression, thresholded

SHORT = BlindConfig(noise=0.01, size=0.9, train=3, test=1, duration=20.0)


def stiffness_case() -> BlindCase:
    return blind_case(14, replace(SHORT, kinds=("stiffness_change",)))


@pytest.mark.slow
def test_both_name_a_plain_stiffness_change() -> None:
    case = stiffness_case()
    truth = key_of(case.truth[0])
    chosen = name_by_aic(case.dataset)
    assert chosen.named == (truth,)
    assert chosen.probability is not None
    assert chosen.probability > 0.9
    found = name_by_regression(case.dataset)
    assert found.named[:1] == (truth,)
    assert found.probability is None


@pytest.mark.slow
def test_regression_names_nothing_in_a_clean_case() -> None:
    assert name_by_regression(blind_case(15, SHORT).dataset).named == ()


def test_aic_pays_two_for_each_parameter_and_each_start_of_a_harmonic_force() -> None:
    certain = certain_of(blind_case(15, SHORT).dataset)
    base = certain.short
    assert aic_of(base) == base.chi2
    kinds = {candidate.kind: candidate for candidate in certain.candidates}
    for kind, price in (("stiffness_change", 2.0), ("gap_stop", 4.0)):
        more = replace(base, hypothesis=base.hypothesis.adding(kinds[kind]))
        assert aic_of(more) - aic_of(base) == pytest.approx(price, abs=1e-6)
    forced = replace(base, hypothesis=base.hypothesis.adding(kinds["harmonic_force"]))
    segments = sum(len(batch.data) for batch in base.batches)
    assert aic_of(forced) - aic_of(base) == pytest.approx(2 + 4 * segments, abs=1e-6)


def test_learned_forces_are_what_the_model_lacks_as_far_as_sensors_see() -> None:
    """Correlation 0.9 at 1 % noise: what they see of other forces is not as much alike, as is checked too."""
    case = stiffness_case()
    certain = certain_of(case.dataset)
    learned = latent_forces(certain)
    terms = {term.name: term.force for term in library(certain, learned)}

    def likeness(name: str) -> float:
        inner = slice(20, -20)  # the smoother knows least at the ends
        seen = learned.seen(np.broadcast_to(terms[name], learned.force.shape))[:, inner].ravel()
        own = learned.force[:, inner].ravel()
        return float(seen @ own / np.linalg.norm(seen) / np.linalg.norm(own))

    truth = key_of(case.truth[0])
    assert abs(likeness(truth)) > 0.9
    others = [name for name in terms if name.startswith("stiffness_change") and name != truth]
    assert max(abs(likeness(name)) for name in others) < abs(likeness(truth)) - 0.1


def test_a_clean_motion_needs_no_forces() -> None:
    """Those of the noise are far smaller than those of a spring that lost some of its stiffness."""
    clean, weak = blind_case(14, SHORT), stiffness_case()
    of_clean, of_weak = (latent_forces(certain_of(case.dataset)).force for case in (clean, weak))
    assert np.sqrt(np.mean(of_clean**2)) < 0.2 * np.sqrt(np.mean(of_weak**2))


def test_thresholding_leaves_what_matters() -> None:
    rng = np.random.default_rng(3)
    columns = np.linalg.qr(rng.standard_normal((200, 6)))[0]
    target = columns @ np.array([0.0, 0.8, 0.0, 0.0, -0.6, 0.03])
    found = thresholded(columns, target / np.linalg.norm(target), 0.1)
    assert np.flatnonzero(found).tolist() == [1, 4]
    assert found[[1, 4]] == pytest.approx(np.array([0.8, -0.6]) / np.linalg.norm(target), abs=1e-9)  # without bias
    assert not thresholded(columns, target / np.linalg.norm(target), 1.1).any()
