"""The blind benchmark: rates with intervals, confusion matrix, calibration curve, pictures and the script."""

import json
from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import get_args

import pytest
from typer.testing import CliRunner

from benchmarks.blind import cases, figures, grid, summary
from benchmarks.blind.cases import BlindResult, Task, all_done, tasks, words_of
from benchmarks.blind.confusion import confusion
from benchmarks.blind.confusion import text as confusion_text
from benchmarks.blind.rates import FORECAST, Rate, Share, rates, table
from benchmarks.blind.reliability import calibration
from benchmarks.blind.reliability import text as calibration_text
from benchmarks.blind_cases import BRIDGE_KINDS, FAR_KINDS, KINDS, OUTSIDE, BlindConfig, Excitation, bridge_draw, chain
from benchmarks.blind_cases.kinds import NOT_DRAWN, kinds_of
from fe_models.causes.base import CAUSES
from scripts.benchmark import app
from tests.blind_results import (
    CUBIC,
    EXPLAINED,
    FINE,
    HEAVY,
    UNEXPLAINED,
    WEAK_2,
    WEAK_3,
    answer,
    case_of,
    diagnosis,
    finding,
    result,
)


def some_results() -> list[BlindResult]:
    """Two right, a wrong place with the right one a rival, a wrong kind; two clean, one called wrong; one outside."""
    outside = case_of(outside=("drifting_stiffness",))
    return [
        result(case_of(WEAK_2), diagnosis(EXPLAINED, finding(WEAK_2, 0.99)), answer(WEAK_2, probability=0.99)),
        result(case_of(HEAVY), diagnosis(EXPLAINED, finding(HEAVY, 0.6)), answer(CUBIC, probability=0.99)),
        result(
            case_of(WEAK_2),
            diagnosis(EXPLAINED, finding(WEAK_3, 0.95, 0.0, 0.01, WEAK_2)),
            answer(WEAK_2, probability=0.99),
        ),
        result(case_of(CUBIC), diagnosis(EXPLAINED, finding(HEAVY, 0.55)), answer(probability=0.99)),
        result(case_of(), diagnosis(UNEXPLAINED), answer(CUBIC, probability=0.99)),
        result(case_of(), diagnosis(FINE, seconds=31.0), answer(probability=0.99)),
        result(outside, diagnosis(UNEXPLAINED), answer(CUBIC, probability=0.99)),
    ]


def by_name(found: Sequence[Rate]) -> dict[str, Rate]:
    return {rate.what: rate for rate in found}


@pytest.mark.parametrize(
    ("hits", "count", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_intervals_are_the_published_ones(hits: int, count: int, low: float, high: float) -> None:
    """R. G. Newcombe, Statistics in Medicine 17, 1998, table I, method 3; four digits, so half of the last."""
    assert Share(hits, count).interval == pytest.approx((low, high), abs=5e-5)


def test_rates_count_what_they_say() -> None:
    found = by_name(rates(some_results(), tier="off"))
    first = found["kind and place right, first"]
    assert (first.measured, first.peers) == (Share(2, 4), (Share(2, 4),))
    assert first.aim == ">= 95 %"
    assert found["first or among the alternatives"].measured == Share(3, 4)
    wrong = found["wrong name at >= 0.9"]
    assert (wrong.measured, wrong.peers) == (Share(1, 7), (Share(3, 7),))
    clean = found["clean case called wrong"]
    assert (clean.measured, clean.peers) == (Share(1, 2), (Share(1, 2),))
    outside = found["outside the list: said so, nothing named at >= 0.9"]
    assert (outside.measured, outside.peers) == (Share(1, 1), (Share(0, 1),))
    assert found[FORECAST].measured == Share(6, 6)  # outside does not count
    assert found["seconds of one core, median"].measured == 5.0
    assert found["seconds of one core, worst"].measured == 31.0
    assert "two at once: both found" not in found


def test_second_cause_that_forecasts_do_not_need_is_counted_apart() -> None:
    pair, named = case_of(WEAK_2, HEAVY), finding(WEAK_2, 0.99)
    found = by_name(
        rates(
            [
                result(pair, diagnosis(EXPLAINED, named, finding(HEAVY, 0.99))),
                result(pair, diagnosis(EXPLAINED, named, over_floor=1.005)),  # as good as without noise's share
                result(pair, diagnosis(EXPLAINED, named, over_floor=1.02)),
                result(pair, diagnosis(UNEXPLAINED, over_floor=1.005)),
                result(pair, diagnosis(EXPLAINED, finding(CUBIC, 0.6), over_floor=1.005)),
            ],
            "exact",
        )
    )
    assert found["two at once: both found"].measured == Share(1, 5)
    assert found["the same, where forecasts need both"].measured == Share(1, 4)


def test_a_peer_without_probabilities_is_not_called_unsure() -> None:
    found = by_name(rates([result(case_of(CUBIC), diagnosis(FINE), answer(HEAVY))], tier="off"))
    assert found["wrong name at >= 0.9"].peers == (None,)
    assert found["kind and place right, first"].peers == (Share(0, 1),)


def test_an_exact_nominal_model_has_stricter_aims() -> None:
    found = by_name(rates(some_results(), tier="exact"))
    assert found["kind and place right, first"].aim == ">= 99 %"
    assert found[FORECAST].measured == Share(0, 6)


def test_a_cause_in_one_recording_has_aims_of_its_own_and_is_no_matter_of_forecasts() -> None:
    named, unnamed = diagnosis(EXPLAINED, finding(WEAK_2, 0.99)), diagnosis(FINE, over_floor=1.0)
    results = [result(case_of(WEAK_2), named), result(case_of(WEAK_2), unnamed)]
    everywhere, one = by_name(rates(results, "far")), by_name(rates(results, "far", "one"))
    assert [found["kind and place right, first"].aim for found in (everywhere, one)] == [">= 75 %", ">= 90 %"]
    assert one["kind and place right, first"].measured == Share(1, 2)
    assert everywhere["the same, of causes that forecasts need"].measured == Share(1, 1)
    assert "the same, of causes that forecasts need" not in one


def test_modes_under_unknown_forces_forecast_nothing_and_have_aims_of_their_own() -> None:
    results = [result(case_of(WEAK_2), diagnosis(EXPLAINED, finding(WEAK_2, 0.99), over_floor=inf))]
    found = by_name(rates(results, "far", "one", "ambient"))
    assert (found["kind and place right, first"].measured, found["kind and place right, first"].aim) == (
        Share(1, 1),
        ">= 80 %",
    )
    assert FORECAST not in found
    assert not any("noise floor, median" in what for what in found)
    assert by_name(rates(results, "exact", "all", "base"))["kind and place right, first"].aim == ">= 95 %"


def test_the_table_has_a_column_for_each_peer() -> None:
    lines = table(rates(some_results(), tier="off"), ("peer",)).splitlines()
    assert {line.count("|") for line in lines} == {6}
    assert lines[2] == "| kind and place right, first | 50 % (2/4) | 15-85 % | >= 95 % | 50 % (2/4) |"


def test_the_confusion_matrix_counts_kinds_and_tells_places_apart() -> None:
    matrix = confusion(some_results())
    assert matrix.hidden == ("stiffness_change", "added_mass", "cubic_spring", "nothing", "drifting_stiffness")
    assert matrix.named == ("stiffness_change", "added_mass", "nothing", "unexplained")
    assert matrix.counts.tolist() == [[2, 0, 0, 0], [0, 1, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1]]
    assert matrix.right.tolist() == [1, 1, 0, 1, 1]
    assert "stiffness_change         2   .   .   .  1/2" in confusion_text(matrix)


def test_the_calibration_curve_bins_by_probability() -> None:
    bins = calibration(some_results())
    assert [(item.low, item.right) for item in bins] == [(0.5, Share(1, 2)), (0.9, Share(0, 1)), (0.97, Share(1, 1))]
    assert bins[0].promised == pytest.approx(0.575)
    certain = result(case_of(CUBIC), diagnosis(EXPLAINED, finding(CUBIC, 1.0)))
    assert calibration([certain])[0].right == Share(1, 1)  # the last bin holds its upper end
    assert calibration_text(bins).splitlines()[1].split()[:4] == ["0.50-0.70", "57.5", "%", "50"]


def test_every_miss_is_reported_with_its_seed() -> None:
    missed = summary.text(some_results(), BlindConfig(tier="off")).split("missed:\n")[1].splitlines()
    assert len(missed) == 3
    wrong_place = "explained, named stiffness_change {'element': 3} (0.950)"
    assert missed[0] == f"seed 1: stiffness_change {{'element': 2}}: {wrong_place}"


def test_tasks_take_the_words_in_turn_with_fresh_seeds() -> None:
    wanted = tasks(3, 70, ("cubic_spring", "nothing"), BlindConfig())
    assert [(task.seed, task.hidden) for task in wanted] == [
        (70, "cubic_spring"),
        (71, "nothing"),
        (72, "cubic_spring"),
    ]


def test_every_kind_of_a_structure_is_hidden_by_default() -> None:
    assert set(words_of("four_dof")) == {*KINDS, *OUTSIDE, "nothing"}
    assert set(words_of("bridge")) == {*BRIDGE_KINDS, *OUTSIDE, "nothing"}


def test_the_grid_changes_noise_and_size_alone() -> None:
    wanted = grid.grid_tasks(2, 70, ("cubic_spring",), BlindConfig(tier="off"))
    assert len(wanted) == 2 * len(grid.NOISES) * len(grid.SIZES)
    assert {task.seed for task in wanted} == {70, 71}
    assert all(task.config.tier == "off" for task in wanted)
    right, wrong = diagnosis(EXPLAINED, finding(CUBIC, 0.99)), diagnosis(EXPLAINED, finding(HEAVY, 0.99))
    results = [result(case_of(CUBIC), right if t.config.noise < 0.1 else wrong, config=t.config) for t in wanted]
    found = grid.cells(results)
    assert [cell.first.hits for cell in found] == [2] * 8 + [0] * 4
    assert [cell.wrong.hits for cell in found] == [0] * 8 + [2] * 4
    assert len(grid.table(found).splitlines()) == 14


def test_pictures_are_drawn(tmp_path: Path) -> None:
    results = some_results()
    figures.draw_confusion(confusion(results)).save(tmp_path / "confusion.png")
    figures.draw_calibration(calibration(results)).save(tmp_path / "calibration.png")
    cells = [grid.Cell(noise, size, Share(3, 5), Share(4, 5), Share(0, 5)) for noise in (0.01, 0.1) for size in (0, 1)]
    figures.draw_grid(cells).save(tmp_path / "rates.png")
    sizes = [path.stat().st_size for path in tmp_path.glob("*.png")]
    assert len(sizes) == 3
    assert all(8_000 < size < 120_000 for size in sizes)


def test_the_script_writes_and_prints_what_it_finds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def quick(task: Task, peers: tuple[str, ...]) -> BlindResult:
        assert peers == tuple(cases.PEERS)
        assert (task.config.train, task.config.measured) == (2, 3)
        found = diagnosis(EXPLAINED, finding(CUBIC, 0.99))
        return result(case_of(CUBIC), found, answer(CUBIC), task.seed, task.config)

    monkeypatch.setattr(cases, "done", quick)
    options = ["--blind", "2", "--seed", "7", "--kinds", "cubic_spring", "--off", "--out", str(tmp_path)]
    ran = CliRunner().invoke(app, [*options, "--train", "2", "--sensors", "3"])
    assert ran.exit_code == 0, ran.output
    assert "| kind and place right, first | 100 % (2/2) |" in ran.output
    content = json.loads((tmp_path / "blind.json").read_text())
    assert [case["seed"] for case in content["cases"]] == [7, 8]
    assert (content["tier"], content["acts"]) == ("off", "all")
    assert content["rates"][0]["value"] == 1.0
    assert {path.name for path in tmp_path.glob("*.png")} == {"blind_confusion.png", "blind_calibration.png"}


def test_the_script_asks_for_far_cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Task] = []

    def quick(task: Task, peers: tuple[str, ...]) -> BlindResult:
        asked.append(task)
        return result(case_of(WEAK_2), diagnosis(EXPLAINED, finding(WEAK_2, 0.99)), None, task.seed, task.config)

    monkeypatch.setattr(cases, "done", quick)
    options = ["--blind", "4", "--structure", "bridge", "--no-peers", "--out", str(tmp_path)]
    ran = CliRunner().invoke(app, [*options, "--tier", "far", "--acts", "one"])
    assert ran.exit_code == 0, ran.output
    assert [task.hidden for task in asked] == list(FAR_KINDS)
    assert {(task.config.tier, task.config.acts) for task in asked} == {("far", "one")}
    content = json.loads((tmp_path / "blind.json").read_text())
    assert (content["tier"], content["acts"]) == ("far", "one")
    refused = CliRunner().invoke(app, [*options, "--tier", "far", "--off"])
    assert refused.exit_code == 2
    assert "--off and --tier far contradict each other" in refused.output


def test_the_script_draws_how_the_rates_fall(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def quick(task: Task, peers: tuple[str, ...]) -> BlindResult:
        return result(case_of(CUBIC), diagnosis(EXPLAINED, finding(CUBIC, 0.99)), None, task.seed, task.config)

    monkeypatch.setattr(cases, "done", quick)
    ran = CliRunner().invoke(app, ["--rates", "1", "--kinds", "cubic_spring", "--out", str(tmp_path)])
    assert ran.exit_code == 0, ran.output
    assert "| 10 % | 1.00 | 100 % (1/1) |" in ran.output
    assert (tmp_path / "blind_rates.png").is_file()
    assert len(json.loads((tmp_path / "blind_rates.json").read_text())["cells"]) == 12


@pytest.mark.slow
def test_two_processes_answer_in_the_order_of_the_tasks() -> None:
    wanted = tasks(2, 40, ("added_mass", "nothing"), BlindConfig(train=2, test=1, duration=10.0))
    at_hand: list[int] = []
    found = all_done(wanted, jobs=2, finished=lambda results: at_hand.append(len(results)))
    assert [item.task for item in found] == wanted
    assert [len(item.judgement.truth) for item in found] == [1, 0]
    assert at_hand == [1, 2]


def test_a_diagnosis_that_breaks_down_names_the_case(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(_: object) -> None:
        raise FloatingPointError

    monkeypatch.setattr(cases, "diagnose", broken)
    (task,) = tasks(1, 40, ("added_mass",), BlindConfig(train=2, test=1, duration=10.0))
    with pytest.raises(FloatingPointError) as caught:
        cases.done(task)
    assert caught.value.__notes__ == ["while the blind case of seed 40 was diagnosed: added_mass hidden"]


def test_every_cause_of_the_list_is_drawn_or_left_out_for_a_reason() -> None:
    """A new cause must come into the draws, with its sizes, or be listed with the reason why it does not."""
    registered = {kind for kind, cause in CAUSES.items() if cause.__module__.startswith("fe_models.")}
    for kinds, sizes in ((KINDS, chain.SIZES), (BRIDGE_KINDS, bridge_draw.SIZES)):
        assert set(kinds) <= registered
        assert registered - set(kinds) <= NOT_DRAWN.keys()
        assert set(kinds) <= sizes.keys()
    for excitation in get_args(Excitation):
        assert set(kinds_of("four_dof", excitation)) <= registered & chain.SIZES.keys()
    assert set(kinds_of("four_dof", "measured")) - set(KINDS) == {"load_gain", "load_delay", "quadratic_spring"}
    assert not NOT_DRAWN.keys() - (registered - set(KINDS))  # no reason without a cause that is left out
