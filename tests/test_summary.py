"""The scores in plain words: every number where it belongs, and nothing said that is not so."""

from copy import deepcopy
from typing import Any

import pytest

from hybrid.config import Config, ModelConfig, TrainingConfig, paper_preset
from hybrid.training.summary import MEANING, NOTHING_LEARNED, band_warning, describe, window_notes


def scores(nrmse: float, r2: float) -> dict[str, float]:
    return {"nrmse": nrmse, "r2": r2, "nrmse_first_16_windows": nrmse / 2, "r2_first_16_windows": r2 / 2}


METRICS: dict[str, Any] = {
    "training": {"left_out": []},
    "test": {
        "recordings": ["r4", "r5"],
        "windows": 76,
        "overlapping": True,
        "window_samples": 500,
        "encoder_samples": 10,
    },
    "scores": {
        "fe": {"measured": scores(0.2, -0.5), "held_out": scores(0.3, 0.1)},
        "hybrid": {"measured": scores(0.04, 0.98), "held_out": scores(0.06, 0.9)},
    },
}


def changed(part: str, **values: object) -> dict[str, Any]:
    metrics = deepcopy(METRICS)
    metrics[part] |= values
    return metrics


def line_of(text: str, words: str) -> list[str]:
    (line,) = [line for line in text.splitlines() if line.strip().startswith(words)]
    return line.removeprefix(line[: line.index(words)] + words).split()


@pytest.mark.parametrize(
    ("words", "numbers"),
    [
        ("measured channels", ["0.2000", "-0.500", "0.0400", "0.980"]),
        ("first 16 windows", ["0.1000", "-0.250", "0.0200", "0.490"]),
        ("channels never fitted", ["0.3000", "0.100", "0.0600", "0.900"]),
        ("their first 16 windows", ["0.1500", "0.050", "0.0300", "0.450"]),
    ],
)
def test_each_number_stands_in_its_line(words: str, numbers: list[str]) -> None:
    """In the order of the header: NRMSE and R2 of the FE model, then of the hybrid."""
    text = describe(METRICS)
    assert line_of(text, words) == numbers
    assert text.index("FE model") < text.index("hybrid")
    assert line_of(text, "NRMSE  ") == ["R2", "NRMSE", "R2"]


def test_columns_stand_below_each_other() -> None:
    lines = [line for line in describe(METRICS).splitlines() if "0." in line and "windows of" not in line]
    assert len(lines) == 4
    assert {tuple(i for i, sign in enumerate(line) if sign == ".") for line in lines} == {(30, 40, 48, 58)}


def test_it_says_what_was_tested_and_what_scores_mean() -> None:
    text = describe(METRICS)
    assert "Tested on r4, r5: 76 windows of 500 samples, each forecast from its first 10." in text
    assert text.endswith(MEANING)
    assert "left out" not in text
    assert "displacement field" not in text


def test_windows_that_do_not_overlap_have_no_first_ones() -> None:
    assert "first 16" not in describe(changed("test", overlapping=False))


def test_without_held_out_sensors_nothing_is_said_about_them() -> None:
    metrics = deepcopy(METRICS)
    for model in metrics["scores"].values():
        model["held_out"] = None
    text = describe(metrics)
    assert "never fitted" not in text
    assert "their first 16" not in text
    assert line_of(text, "measured channels")


def test_the_field_is_scored_where_the_truth_is_known() -> None:
    text = describe({**METRICS, "field": {"fe": 0.1234, "hybrid": 0.0456}})
    assert line_of(text, "displacement field (*)") == ["0.1234", "0.0456"]
    assert "simulated truth" in text


def test_recordings_left_out_are_named_one_a_line() -> None:
    first, second = describe(changed("training", left_out=["r1", "r3"])).splitlines()[:2]
    assert first.startswith("Training recording r1 was left out")
    assert second.startswith("Training recording r3 was left out")


def test_without_test_recordings_that_is_said() -> None:
    text = describe({**changed("training", left_out=["r1"]), "test": None, "scores": None})
    assert "r1 was left out" in text
    assert text.endswith("The dataset has no test recording, so that nothing is scored.")


def test_experts_are_named_with_their_weights() -> None:
    text = describe(changed("test", expert_weights={"r1": 0.254, "r3": 0.746}))
    assert "Experts, one model each of r1 (weight 0.25), r3 (weight 0.75)." in text
    assert "Experts" not in describe(METRICS)


def test_a_model_that_learned_nothing_says_so() -> None:
    worse = changed("scores", hybrid={"measured": scores(0.3, -0.01), "held_out": None})
    assert NOTHING_LEARNED in describe(worse)
    assert NOTHING_LEARNED not in describe(METRICS)


def test_short_and_few_windows_are_said() -> None:
    assert window_notes(226, 500, 10, Config()) == []
    (short,) = window_notes(20, 319, 2, Config())
    assert "windows of 319 samples instead of 500, 20 of them" in short
    given = Config(training=TrainingConfig(window=499))
    assert window_notes(20, 499, 2, given) == []
    (few,) = window_notes(1, 499, 2, given)
    assert "1 training window of 499 samples can hardly teach the initial states of 2 modes, which take 4" in few
    assert window_notes(1, 499, 2, paper_preset("four_dof")) == []  # it trains its encoder from nothing
    assert window_notes(1, 499, 2, Config(ModelConfig(encoder="map"), given.training)) == []  # it has none to train


@pytest.mark.parametrize(("inside", "warned"), [(0.5, True), (0.79, True), (0.85, False), (0.97, False)])
def test_a_band_that_held_too_little_is_warned_of(inside: float, warned: bool) -> None:
    lines = band_warning({"bands": {"hybrid": {"measured": inside}}})
    assert bool(lines) == warned
    assert all(f"held {100 * inside:.1f} % of the test recordings, not 90 %" in line for line in lines)
    assert band_warning({}) == []
