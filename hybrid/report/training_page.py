"""The page of a training: how well the hybrid model forecasts what it never saw, and how the structure moves."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from fe_models.linear import LinearModel
from fe_models.pictures.structure_drawing import structure_picture
from fe_models.recordings import Dataset
from hybrid.config import Config
from hybrid.report.assumed_section import what_was_assumed
from hybrid.report.drawings import drawn, pictured
from hybrid.report.field_motion import field_motion
from hybrid.report.page import Block, Cell, Figure, Heading, Page, Paragraph, Section, Table, Tone
from hybrid.report.provenance import Provenance, provenance_of, written_by
from hybrid.report.values import fixed, number, percentage, sentence
from hybrid.report.where import WIDTHS
from hybrid.training.results import Results
from hybrid.training.run import LOOP, Run
from hybrid.training.summary import band_warning

NOT_TESTED = "The hybrid model is trained; no recording was kept for testing, so that nothing is scored."
TEST_ONE = "Keep a recording for testing (role = “test” in the dataset): only that tells what a model is worth."
USE = "Forecast other recordings with hybrid-modal predict; hybrid-modal render draws films and snapshots."
DIAGNOSE = "Where the FE model is far off, hybrid-modal diagnose names the cause."
LEARNED_NOTHING = "It forecasts no better than the mean of each channel: check sensors, units and rates."
HOW = (
    "Forecasts of whole windows of recordings that were never trained on, from their first samples. NRMSE: root mean"
    " square of the error over the window's range. R²: the share of the variance that is explained."
)
CAPTIONS = {
    "channels.png": "Channels of the first test window: measured, and as both models forecast them.",
    "latent.png": "Modal coordinates and velocities of the first test window.",
    "displacement.png": "Displacement where it is largest, of the first test window.",
    LOOP: "Inertia force against displacement at node 1: a spring that is not linear bends the loop.",
    "training.png": "The training: loss a sample, and how many samples were forecast in each epoch.",
}
MODELS = {"fe": "FE model", "hybrid": "hybrid", "whole_record": "hybrid, given whole records"}


def training_page(dataset: Dataset, config: Config, found: Results, provenance: Provenance) -> Page:
    """Return the page of a training with a ``config`` on a ``dataset``."""
    name = "imported matrices" if isinstance(dataset.model, LinearModel) else dataset.model.name
    said, tone = _answer(found.metrics)
    sections = (
        _where(dataset),
        Section("better", "How much better", tuple(_better(found))),
        Section("why", "Why believe it", tuple(_evidence(dataset, found))),
        Section("unknown", "What is not known", tuple(_unknown(dataset, found.metrics))),
        what_was_assumed(dataset, provenance, settings=_settings(config, found.metrics)),
    )
    return Page(
        title=f"Hybrid model of {name}",
        verdict="How well the hybrid model forecasts",
        tone=tone,
        sentence=said,
        summary="",
        facts=tuple(_facts(found.metrics)),
        next=tuple(_next(found.metrics)),
        sections=sections,
        footer=written_by(provenance),
    )


def page_from_files(run: Run, dataset: Dataset, found: Results, command: Sequence[str], file: Path) -> Page:
    """Return the page of a training on the ``dataset`` of a ``file``, by the words of a ``command``."""
    source = provenance_of(command, file, f"of seed {run.config.training.seed}", run.seconds)
    return training_page(dataset, run.config, found, source)


def _answer(metrics: dict[str, Any]) -> tuple[str, Tone]:
    scores = metrics["scores"]
    if scores is None:
        return NOT_TESTED, Tone.OPEN
    fe, hybrid = (scores[name]["measured"] for name in ("fe", "hybrid"))
    apart = scores["hybrid"]["held_out"]
    told = (
        f"The hybrid model forecasts recordings that it never saw with an error (NRMSE) of {hybrid['nrmse']:.4f}, the"
        f" FE model alone with {fe['nrmse']:.4f}"
    )
    told += "." if apart is None else f"; sensors that were never fitted with {apart['nrmse']:.4f}."
    if hybrid["r2"] <= 0:
        return told, Tone.BAD
    return told, Tone.GOOD if hybrid["nrmse"] < fe["nrmse"] else Tone.OPEN


def _facts(metrics: dict[str, Any]) -> Iterator[tuple[str, str]]:
    scores = metrics["scores"]
    if scores is not None:
        fe, hybrid = (scores[name]["measured"]["nrmse"] for name in ("fe", "hybrid"))
        yield "forecast error, FE model → hybrid", f"{fe:.4f} → {hybrid:.4f}"
        yield "explained of the variance", percentage(max(scores["hybrid"]["measured"]["r2"], 0.0))
        inside = metrics.get("bands", {}).get("hybrid")
        if inside:
            yield "inside the 90 % band", percentage(inside["measured"])
    yield "training windows", str(metrics["training"]["windows"])


def _next(metrics: dict[str, Any]) -> Iterator[str]:
    scores = metrics["scores"]
    if scores is None:
        yield TEST_ONE
    elif scores["hybrid"]["measured"]["r2"] <= 0:
        yield LEARNED_NOTHING
    yield USE
    yield DIAGNOSE


def _where(dataset: Dataset) -> Section:
    names = ", ".join(sensor.name for sensor in dataset.sensors)
    drawing = pictured(
        structure_picture(dataset.model, dataset.sensors, WIDTHS),
        "The structure with the numbers of nodes and elements; arrows are sensors, along what they measure. The model"
        " forecasts all of it, not only where sensors are.",
        f"Drawing of the structure with sensors {names}.",
    )
    return Section("where", "Where", (drawing,))


def _better(found: Results) -> Iterator[Block]:
    metrics = found.metrics
    if metrics["scores"] is None:
        yield Paragraph(NOT_TESTED)
        return
    test = metrics["test"]
    names = ", ".join(test["recordings"])
    yield Paragraph(
        f"Tested on {names}: {test['windows']} windows of {test['window_samples']} samples, each forecast from its"
        f" first {test['encoder_samples']}. {HOW}"
    )
    yield _scores(metrics["scores"])
    if "channels.png" in found.curves:
        yield _figure(found, "channels.png")
    yield _channels(metrics["scores"])


def _scores(scores: dict[str, Any]) -> Table:
    rows = []
    for name, words in MODELS.items():
        own = scores.get(name)
        if own is not None:
            cells = [
                fixed(None if own[role] is None else own[role][score], decimals)
                for role in ("measured", "held_out")
                for score, decimals in (("nrmse", 4), ("r2", 3))
            ]
            rows.append((Cell(words), *cells))
    columns = ("model", "NRMSE, measured sensors", "R²", "NRMSE, sensors never fitted", "R²")
    return Table("Forecasts of the test recordings.", columns, tuple(rows))


def _channels(scores: dict[str, Any]) -> Table:
    fe, hybrid = (scores[name]["channels"] for name in ("fe", "hybrid"))
    rows = tuple(
        (
            Cell(name),
            Cell("yes" if own["role"] == "measured" else "never"),
            fixed(fe[name]["nrmse"], 4),
            fixed(own["nrmse"], 4),
            fixed(own["r2"], 3),
        )
        for name, own in hybrid.items()
    )
    columns = ("channel", "fitted", "NRMSE, FE model", "NRMSE, hybrid", "R², hybrid")
    return Table("Forecasts, channel by channel.", columns, rows)


def _figure(found: Results, name: str) -> Figure:
    caption = CAPTIONS[name]
    return drawn(found.curves[name], name.removesuffix(".png"), caption, f"Curves over time or each other. {caption}")


def _evidence(dataset: Dataset, found: Results) -> Iterator[Block]:
    moving = None if found.prediction is None else field_motion(dataset.model, found.prediction)
    if moving is not None:
        yield Heading("The motion of the whole structure")
        yield moving
    for name in CAPTIONS:
        if name in found.curves and name != "channels.png":
            yield _figure(found, name)
    inside = found.metrics.get("bands", {}).get("hybrid")
    if inside:
        share = percentage(inside["measured"])
        yield Paragraph(f"Of the measured channels {share} lie inside the bands that should hold 90 % of them.")


def _unknown(dataset: Dataset, metrics: dict[str, Any]) -> Iterator[Block]:
    for name in metrics["training"]["left_out"]:
        yield Paragraph(f"Recording {name} was left out: it contradicts the others, as if the structure had changed.")
    for line in band_warning(metrics):
        yield Paragraph(sentence(line))
    if not any(sensor.role == "held_out" for sensor in dataset.sensors):
        yield Paragraph("No sensor was kept apart: how well the model forecasts where none is, was not tested.")
    yield Paragraph("Between sensors the motion is as right as the model's mode shapes are.")


def _settings(config: Config, metrics: dict[str, Any]) -> Table:
    training = metrics["training"]
    rows = {
        "training recordings": ", ".join(training["recordings"]),
        "windows": f"{training['windows']} of {training['window_samples']} samples",
        "epochs": str(training["epochs"]),
        "linear model leaves": percentage(float(training["linear_model_unexplained"] or 0.0)),
        **{word.replace("_", " "): _words(value) for word, value in vars(config.model).items()},
        **{word.replace("_", " "): _words(value) for word, value in vars(config.training).items() if word != "epochs"},
    }
    cells = tuple((Cell(word), Cell(value)) for word, value in rows.items())
    return Table("How the model was trained.", ("setting", "value"), cells)


def _words(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return number(value).text
    return "chosen by the program" if value is None else str(value)
