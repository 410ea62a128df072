"""Force laws that a diagnosis by modes finds in simulated recordings: kind and place, and what is on no list."""

import pytest

from benchmarks.blind.judging import key_of
from benchmarks.blind_cases import BlindConfig, blind_case
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.modes_and_motion.modal_diagnosis import diagnose_modes
from hybrid.diagnosis.outcome.verdict import Verdict

SLOW = pytest.mark.slow


def found_in(seed: int, kind: str) -> tuple[list[str], ModalDiagnosis]:
    """The keys of what is hidden in a chain that is off by 1 %, and the diagnosis."""
    case = blind_case(seed, BlindConfig(kinds=(kind,) if kind else (), tier="off", size=0.7))
    return [key_of(cause) for cause in case.truth], diagnose_modes(case.dataset)


@pytest.mark.parametrize(
    ("seed", "kind"),
    [
        pytest.param(9200, "cubic_spring", marks=SLOW),
        pytest.param(312, "coulomb_friction", marks=SLOW),
        pytest.param(313, "quadratic_damper", marks=SLOW),
        pytest.param(314, "gap_stop", marks=SLOW),
        pytest.param(315, "slack_cable", marks=SLOW),
    ],
)
def test_law_is_named_with_its_place(seed: int, kind: str) -> None:
    truth, found = found_in(seed, kind)
    assert [key_of(found.findings[0].cause)] == truth
    assert found.findings[0].probability > 0.9  # rather sure, of an effect that is large
    assert found.findings[0].explains > 0.9


@pytest.mark.slow
def test_clean_chain_has_no_law() -> None:
    _, found = found_in(316, "")
    assert not found.findings
    assert found.verdict is Verdict.NOTHING_WRONG


@SLOW
@pytest.mark.parametrize("kind", ["creeping_spring", "drifting_stiffness"])
def test_what_is_on_no_list_is_left_unexplained(kind: str) -> None:
    _, found = found_in(317, kind)
    assert found.verdict in (Verdict.UNEXPLAINED, Verdict.PARTLY_EXPLAINED)
    assert all(item.probability < 0.9 for item in found.findings if len(item.alternatives))
    assert "not on the list may look like both" in " ".join(found.notes) or "no force law on the list" in " ".join(
        found.notes
    )
