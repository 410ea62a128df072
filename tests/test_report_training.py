"""The page of a training: scores in its sentence, the motion of all nodes, and what was not tested."""

from typing import Any

import numpy as np
import pytest

import fe_models as fe
from fe_models.files.run_folder import Prediction
from fe_models.recordings import Dataset, Recording
from hybrid.config import Config
from hybrid.figures import draw_channels
from hybrid.report.page import Tone
from hybrid.report.rendering import rendered
from hybrid.report.training_page import training_page
from hybrid.training.results import Results
from tests.pages import HOSTILE, SOURCE, Reader
from tests.test_modal_evidence import SENSORS, chain

RATE, SAMPLES = 20.0, 400


def data_of_training(name: str = "train") -> Dataset:
    """Return recordings of noise: of a training its page shows scores that others have made."""
    data = np.random.default_rng(0).standard_normal((1, SAMPLES, len(SENSORS)))
    return Dataset(chain(), RATE, SENSORS, (Recording(name, data), Recording("test", data, "test")))


def scores(nrmse: float, r2: float) -> dict[str, Any]:
    measured = {"nrmse": nrmse, "r2": r2}
    channels = {sensor.name: {"role": "measured", **measured} for sensor in SENSORS}
    return {"measured": measured, "held_out": None, "channels": channels}


def trained(hybrid: float = 0.02, r2: float = 0.98, name: str = "train") -> Results:
    """Return the results of a training whose hybrid has these scores."""
    modal = fe.natural_modes(chain(), 3)
    time = np.arange(SAMPLES) / RATE
    q = np.cos(np.outer(time, modal.omega))
    field = q @ modal.shapes.T
    prediction = Prediction(time, field, 0.8 * field, field[0], None, "m", SENSORS)
    metrics = {
        "training": {
            "recordings": [name],
            "left_out": ["odd one"],
            "linear_model_unexplained": 0.2,
            "windows": 12,
            "window_samples": SAMPLES,
            "epochs": 3,
        },
        "test": {"recordings": ["test"], "windows": 2, "window_samples": SAMPLES, "encoder_samples": 10},
        "scores": {"fe": scores(0.2, 0.1), "hybrid": scores(hybrid, r2)},
        "bands": {"hybrid": {"measured": 0.7}},
    }
    curves = {"measured": field[:, :2], "hybrid": 0.9 * field[:, :2]}
    sheet = draw_channels(time, curves, ["x1 (m)", "x2 (m)"], "title")
    return Results(metrics, prediction, {"channels.png": sheet})


def test_a_training_is_told_by_its_forecasts() -> None:
    page = training_page(data_of_training(), Config(), trained(), SOURCE)
    assert page.sentence == (
        "The hybrid model forecasts recordings that it never saw with an error (NRMSE) of 0.0200, the FE model alone"
        " with 0.2000."
    )
    assert page.tone is Tone.GOOD
    assert dict(page.facts)["forecast error, FE model → hybrid"] == "0.2000 → 0.0200"
    assert [own.title for own in page.sections] == [
        "Where",
        "How much better",
        "Why believe it",
        "What is not known",
        "What was assumed",
    ]
    html = rendered(page)
    Reader(html)
    for words in ("odd one was left out", "bands of", "No sensor was kept apart", "Of the measured channels 70 %"):
        assert words in html, words


@pytest.mark.parametrize(("hybrid", "r2", "tone"), [(0.3, 0.2, Tone.OPEN), (0.4, -0.1, Tone.BAD)])
def test_a_model_that_is_no_better_does_not_look_so(hybrid: float, r2: float, tone: Tone) -> None:
    page = training_page(data_of_training(), Config(), trained(hybrid, r2), SOURCE)
    assert page.tone is tone
    assert any("check sensors" in line for line in page.next) == (tone is Tone.BAD)


def test_without_a_recording_for_testing_nothing_is_claimed() -> None:
    done = trained()
    page = training_page(data_of_training(), Config(), Results(done.metrics | {"scores": None}, None, {}), SOURCE)
    assert "nothing is scored" in page.sentence
    assert page.tone is Tone.OPEN
    assert "Keep a recording" in page.next[0]


def test_names_are_texts_here_too() -> None:
    html = rendered(training_page(data_of_training(HOSTILE), Config(), trained(name=HOSTILE), SOURCE))
    assert HOSTILE not in html
    assert HOSTILE in " ".join(Reader(html).texts)
