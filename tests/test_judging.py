"""Judgements of a diagnosis and of a peer: what counts as right, as listed, as confidently wrong."""

import pytest

from benchmarks.blind.judging import judge
from benchmarks.peers.answer import Answer, mark
from fe_models.causes import Cause
from tests.blind_results import (
    CUBIC,
    EXPLAINED,
    FINE,
    HEAVY,
    PARTLY,
    UNEXPLAINED,
    WEAK_2,
    WEAK_3,
    answer,
    case_of,
    diagnosis,
    finding,
)


def test_right_kind_and_place_is_right() -> None:
    found = judge(case_of(WEAK_2), diagnosis(EXPLAINED, finding(WEAK_2, 0.95)))
    assert found.first
    assert found.listed
    assert not found.confidently_wrong
    assert found.probabilities == ((0.95, True),)
    assert found.over_floor == pytest.approx(1.1)


def test_right_kind_at_a_wrong_place_is_wrong_but_listed_where_the_right_one_is_a_rival() -> None:
    sure = judge(case_of(WEAK_2), diagnosis(EXPLAINED, finding(WEAK_3, 0.9)))
    assert (sure.first, sure.listed, sure.confidently_wrong) == (False, False, True)
    torn = judge(case_of(WEAK_2), diagnosis(EXPLAINED, finding(WEAK_3, 0.6, 0.0, 0.01, WEAK_2)))
    assert (torn.first, torn.listed, torn.confidently_wrong) == (False, True, False)


def test_a_clean_case_is_right_where_nothing_is_wrong() -> None:
    assert judge(case_of(), diagnosis(FINE)).first
    assert not judge(case_of(), diagnosis(UNEXPLAINED)).first
    assert judge(case_of(), diagnosis(EXPLAINED, finding(HEAVY, 0.99))).confidently_wrong


def test_outside_of_the_list_the_verdict_counts() -> None:
    case = case_of(outside=("creeping_spring",))
    assert judge(case, diagnosis(PARTLY, finding(CUBIC, 0.5))).first
    assert judge(case, diagnosis(UNEXPLAINED)).first
    assert not judge(case, diagnosis(EXPLAINED, finding(CUBIC, 0.5))).first
    assert judge(case, diagnosis(PARTLY, finding(CUBIC, 0.9))).confidently_wrong


def test_of_two_causes_both_must_be_found_in_any_order() -> None:
    case = case_of(WEAK_2, HEAVY)
    assert judge(case, diagnosis(EXPLAINED, finding(HEAVY, 0.99), finding(WEAK_2, 0.99))).first
    half = judge(case, diagnosis(EXPLAINED, finding(HEAVY, 0.99)))
    assert (half.first, half.confidently_wrong) == (False, False)


@pytest.mark.parametrize(
    ("off", "std", "within", "covered"),
    [
        (0.07, 0.01, True, False),  # 8.75 % of 0.8
        (0.09, 0.01, False, False),
        (0.09, 0.047, True, True),  # 1.915 standard deviations
        (0.09, 0.0455, True, False),  # 1.978
    ],
)
def test_parameters_are_close_within_a_tenth_or_two_standard_deviations(
    off: float, std: float, within: bool, covered: bool
) -> None:
    found = judge(case_of(WEAK_2), diagnosis(EXPLAINED, finding(WEAK_2, 0.95, off, std)))
    assert (found.within, found.covered) == ((within,), (covered,))


@pytest.mark.parametrize(
    ("truth", "given", "first", "wrong"),
    [
        ((WEAK_2,), answer(WEAK_2, probability=0.99), True, False),
        ((WEAK_2,), answer(WEAK_2, WEAK_3), True, False),
        ((WEAK_2,), answer(WEAK_3, WEAK_2), False, False),
        ((WEAK_2,), answer(WEAK_3, probability=0.99), False, True),
        ((WEAK_2,), answer(WEAK_3, probability=0.89), False, False),
        ((), Answer(()), True, False),
        ((), Answer((), 0.95), True, False),
        ((), answer(CUBIC, probability=0.95), False, True),
        ((WEAK_2, HEAVY), answer(HEAVY, WEAK_2), True, False),
        ((WEAK_2, HEAVY), answer(HEAVY, probability=0.95), False, False),
    ],
)
def test_marks_of_a_peer(truth: tuple[Cause, ...], given: Answer, first: bool, wrong: bool) -> None:
    marks = mark(case_of(*truth), given, 1.0)
    assert (marks.first, marks.confidently_wrong) == (first, wrong)


def test_outside_of_the_list_a_peer_must_be_unsure_or_silent() -> None:
    case = case_of(outside=("drifting_stiffness",))
    assert mark(case, Answer(()), 1.0).first
    assert mark(case, answer(CUBIC, probability=0.6), 1.0).first
    assert not mark(case, answer(CUBIC), 1.0).first
    sure = mark(case, answer(CUBIC, probability=0.9), 1.0)
    assert (sure.first, sure.confidently_wrong) == (False, True)
