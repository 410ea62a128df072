"""Claims about some of the recordings alone, and whether they say that recordings differ."""

import numpy as np
import pytest

from fe_models.recordings import Dataset
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.response.hypothesis import Hypothesis
from tests.test_modal_evidence import chain, dataset, measured_of, modes_of, search_of

__all__ = ["dataset"]  # a fixture


@pytest.fixture(name="hypothesis")
def _hypothesis(dataset: Dataset) -> Hypothesis:
    """The drawn chain with three candidates."""
    measured = measured_of(dataset, modes_of(chain(), "r", np.random.default_rng(0)))
    return Hypothesis(measured.nominal, search_of(dataset, measured).candidates[:3])


def test_a_claim_about_some_recordings_numbers_them_anew_and_leaves_out_what_is_idle_there(
    hypothesis: Hypothesis,
) -> None:
    found, idle = Claim(hypothesis, ((0,), (1, 2), (0, 1, 2)), (2,)).within([1, 2])
    assert idle == (0,)
    assert found.hypothesis.candidates == hypothesis.candidates[1:]
    assert found.acts == ((0, 1), (0, 1))
    assert found.changed == (1,)


@pytest.mark.parametrize(
    ("acts", "changed", "differ"),
    [
        ((), (), False),
        (((0, 1, 2),), (), False),
        (((0, 1, 2), (1,)), (), True),
        (((0, 1, 2),), (2,), True),
        ((), (0, 1, 2), False),
    ],
)
def test_recordings_differ_where_a_cause_or_an_unknown_change_is_of_some(
    hypothesis: Hypothesis, acts: tuple[tuple[int, ...], ...], changed: tuple[int, ...], differ: bool
) -> None:
    own = Hypothesis(hypothesis.nominal, hypothesis.candidates[: len(acts)])
    assert Claim(own, acts, changed).differs_among(3) is differ
