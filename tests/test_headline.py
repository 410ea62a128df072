"""Headline, probabilities and gain agree: no answer sounds surer than its probability, and probabilities add up."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.causes import AddedMass, CoulombFriction
from hybrid.diagnosis.answer import summary_of
from hybrid.diagnosis.outcome.findings import NOT_ON_THE_LIST, OTHER_CAUSES, Alternative, Finding, Parameter
from hybrid.diagnosis.outcome.named import remainder
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.outcome.verdict import Errors, Verdict, is_contradicted
from hybrid.diagnosis.probability import two_decimals
from hybrid.diagnosis.report import describe_diagnosis, finding_table, headline, score_lines, summary
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from tests.pages import answer_by_modes, answer_by_series, chain_dataset, found_in


def answer(probability: float, *alternatives: Alternative, verdict: Verdict = Verdict.EXPLAINED) -> Any:
    """What a headline reads of a diagnosis that names a mass."""
    finding = Finding(AddedMass(3, 2.5), {}, probability, 1.0, (), alternatives, "")
    return SimpleNamespace(
        verdict=verdict, findings=(finding,), scores={"extended": {"measured": 0.01}}, noise_floor=0.01
    )


def test_a_headline_says_named_of_what_is_probable_alone() -> None:
    elsewhere = Alternative("added_mass", {"node": 4}, 0.4)
    other = Alternative("cubic_spring", {"node": 1, "direction": "x"}, 0.4)
    assert headline(answer(0.9)).endswith("the cause is named below.")
    assert "leave its place open" in headline(answer(0.4, elsewhere))
    assert "cannot tell which" in headline(answer(0.17, other))
    assert "part of it" in headline(answer(0.17, other, verdict=Verdict.PARTLY_EXPLAINED))


def test_a_headline_says_by_whose_measure_nothing_is_wrong() -> None:
    found = answer(0.9, verdict=Verdict.NOTHING_WRONG)
    worse: Any = SimpleNamespace(**vars(found) | {"scores": {"extended": {"measured": 0.012}}, "tolerance": 0.25})
    assert headline(found).endswith("forecasts as well as the noise lets it.")
    assert headline(worse).endswith("forecasts to within the stated tolerance, 25% of the noise floor.")
    worse.tolerance = 0.1
    assert "leaves nothing but noise" in headline(worse)


def test_places_that_move_alike_share_a_probability_and_the_kind_s_own_is_said() -> None:
    places = [Alternative("coulomb_friction", {"node": node, "direction": "x"}, 0.33) for node in (3, 4)]
    named = Finding(CoulombFriction((2,), "x", 4.0), {}, 0.33, 1.0, (), tuple(places), "Friction.")
    assert finding_table(named)["probability_of_kind"] == pytest.approx(0.99)
    (line,) = [line for line in lines_of(named) if "Probability" in line]
    assert line.startswith(
        "  Probability 0.33 at this place, 0.99 of its kind (Coulomb friction), here or at node 3 in x (0.33), at"
    )
    assert not any("ruled out" in line for line in lines_of(named))


def test_a_rival_has_its_size_where_that_is_known() -> None:
    force = {"force": Parameter(-9e5, 3e4, "N")}
    rivals = (Alternative("axial_force", {"element": 2}, 0.14, force), Alternative("added_mass", {"node": 1}, 0.1))
    named = Finding(AddedMass(3, 2.5), {}, 0.7, 1.0, (), rivals, "A mass.")
    assert "  Cannot be ruled out: axial force at element 2, force -9e+05 +- 3e+04 N (0.14)." in lines_of(named)
    listed = finding_table(named)["alternatives"]
    assert listed[0]["parameters"] == {"force": {"value": -9e5, "std": 3e4, "unit": "N"}}
    assert listed[1]["parameters"] == {}


def test_both_searches_say_the_same_in_the_same_words() -> None:
    dataset = chain_dataset()
    finding = replace(found_in(dataset), gain=0.3)
    by_series = summary_of(answer_by_series(dataset, finding))
    by_modes = summary_of(answer_by_modes(dataset, finding))
    for words in (
        "  Probability 0.97; explains 90% of",
        "  Cannot be ruled out: cubic spring at node 4 in x, stiffness 12 +- 3 N/m^3 (0.02).",
        "  Something that is not on the list of causes: 0.01.",
        "Left unexplained: 2.0% of",
    ):
        assert words in by_series and words in by_modes
    assert "90% of the forecast error's energy beyond noise." in by_series
    assert "90% of the modes' misfit (chi-square)." in by_modes
    assert "it removes 30% of the forecast error's energy beyond noise" in by_modes
    assert "are no better for it" in summary_of(answer_by_modes(dataset, replace(finding, gain=0.0)))


def test_no_probability_is_said_to_be_one_or_zero() -> None:
    assert [two_decimals(own) for own in (0.9991, 0.995, 0.9949, 0.5, 0.005, 0.0049)] == [
        *("> 0.99", "0.99", "0.99", "0.50", "0.01", "< 0.01")
    ]


def test_a_forecast_near_or_below_the_noise_floor_is_said_to_be_at_it() -> None:
    def first(error: float, tolerance: float = 0.05) -> str:
        scores = {"baseline": {"measured": 0.2, "held_out": None}, "extended": {"measured": error, "held_out": None}}
        return score_lines(scores, 0.01, tolerance, is_named=True)[0]

    assert first(0.008) == "Forecast NRMSE: 0.2000 before, 0.0080 after, at the noise floor (about 0.0100)."
    assert "at the noise floor" in first(0.0104)
    assert "above the noise floor" in first(0.0106)
    assert "at the noise floor" in first(0.0106, tolerance=0.1)


def lines_of(named: Finding) -> list[str]:
    scores = {"baseline": {"measured": 0.1, "held_out": None}, "extended": {"measured": 0.01, "held_out": None}}
    made: Any = SimpleNamespace(
        verdict=Verdict.EXPLAINED,
        findings=(named,),
        scores=scores,
        noise_floor=0.01,
        tolerance=0.05,
        unexplained=0.0,
        notes=(),
        next_measurement=None,
    )
    return summary(made).splitlines()


def test_what_a_cap_withholds_goes_to_what_is_not_on_the_list() -> None:
    rival = Alternative("cubic_spring", {"node": 1, "direction": "x"}, 0.05)
    found = {item.kind: item.probability for item in remainder(0.15, [rival], listed=0.25)}
    assert found == pytest.approx({OTHER_CAUSES: 0.05, NOT_ON_THE_LIST: 0.75})
    assert remainder(0.999, [], listed=1.0) == []  # too little to be reported


@pytest.mark.slow
def test_a_cause_that_spoils_forecasts_of_held_out_sensors_is_doubted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Held-out sensors that are forecast the worse, the better the measured ones are: as one mounted elsewhere."""
    monkeypatch.setattr(Scorer, "held_out_error", lambda _, forecast: 1 / (1 + forecast.excess))
    case = blind_case(12, BlindConfig(("cubic_spring",), size=0.8, train=5, test=2, duration=20.0))
    found = diagnose(case.dataset)
    assert found.verdict is Verdict.PARTLY_EXPLAINED
    assert any("held-out sensors are forecast worse" in note for note in found.notes)
    finding = found.findings[0]
    assert finding.cause.kind == "cubic_spring"
    assert finding.probability < 0.5
    total = finding.probability + sum(item.probability for item in finding.alternatives)
    assert total == pytest.approx(1.0, abs=0.01)  # alternatives below half a per cent are left out
    assert "not on the list of causes: 0.75" in describe_diagnosis(found)


def test_sensors_that_gain_or_are_not_there_contradict_nothing() -> None:
    errors = Errors(0.2, 0.02, 0.01, 0.0)
    assert not is_contradicted(None, None, errors)
    assert not is_contradicted(0.2, 0.02, errors)
    assert is_contradicted(0.2, 0.202, errors)
    assert not is_contradicted(0.2, 0.202, replace(errors, tolerance=0.3))
