"""Small answers, made by hand, for pages; and what a parser says of a page."""

from dataclasses import replace
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np

import fe_models as fe
from fe_models.causes import StiffnessChange
from fe_models.causes.base import Effect
from fe_models.recordings import Dataset
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.fitting.forecast_score import ForecastScore
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.modes_and_motion.forecasts import MotionForecasts
from hybrid.diagnosis.modes_and_motion.modal_findings import State
from hybrid.diagnosis.modes_and_motion.paired_modes import PairedMode
from hybrid.diagnosis.next_measurement.hypotheses import Cause
from hybrid.diagnosis.next_measurement.measurements import Measurement
from hybrid.diagnosis.next_measurement.recommendation import NextMeasurement, Option
from hybrid.diagnosis.observed.example import Example
from hybrid.diagnosis.observed.observations import Modes, Observations
from hybrid.diagnosis.outcome.calibration import Calibrated
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.outcome.findings import NOT_ON_THE_LIST, Alternative, Finding, Parameter, sentence_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.noise_model import NoiseModel, SensorRoles
from hybrid.report.provenance import InputFile, Provenance
from tests.test_modal_evidence import SENSORS, chain
from tests.test_modal_report import RATE, decays

SAMPLES = 600  # of a recording: figures of these take a second or two
VOID = {"meta", "link", "br", "hr", "input", "img", "path", "use", "image"}  # as HTML has them, or closed as in SVG
SOURCE = Provenance(
    "hybrid-modal diagnose data/dataset.toml --out out",
    (InputFile("dataset.toml", 512, "ab" * 32),),
    (("hybrid-modal", "0.1.0"),),
    datetime(2026, 11, 29, 12, 0, tzinfo=UTC),
    "fixed seeds",
    1.5,
)


class Reader(HTMLParser):
    """The elements of a page, in order, with their attributes; `ValueError` where one is not closed, or not open."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.texts: list[str] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()
        if self.open:
            raise ValueError(f"not closed: {self.open}")

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        if tag in VOID:
            return
        if not self.open or self.open.pop() != tag:
            raise ValueError(f"</{tag}> at {self.getpos()} closes nothing")

    def handle_data(self, data: str) -> None:
        if not {"script", "style"} & set(self.open):
            self.texts.append(data)

    def named(self, tag: str) -> list[dict[str, str | None]]:
        """Return the attributes of all elements of one kind."""
        return [attributes for name, attributes in self.elements if name == tag]


HOSTILE = "<script>alert('x')</script>"
FLOOR, BEFORE, AFTER = 0.01, 0.2, 0.012


def chain_dataset(names: tuple[str, str] = ("before", "after"), sensor: str = "x1", title: str = "chain") -> Dataset:
    """Return two recordings of a chain of five, the second for testing; the first sensor has a name of its own."""
    rng = np.random.default_rng(3)
    structure = replace(chain(), name=title)
    sensors = (replace(SENSORS[0], name=sensor), *SENSORS[1:-1], replace(SENSORS[-1], role="held_out"))
    data = [decays(structure, rng)[:, :SAMPLES] for _ in names]
    recordings = (fe.Recording(names[0], data[0]), fe.Recording(names[1], data[1], "test"))
    return fe.Dataset(structure, RATE, sensors, recordings)


def found_in(dataset: Dataset, probability: float = 0.97) -> Finding:
    """Return a softer third spring, which a cubic spring of the fourth node may be instead."""
    rival = Alternative(
        "cubic_spring", {"node": 4, "direction": "x"}, 0.02, {"stiffness": Parameter(12.0, 3.0, "N/m^3")}
    )
    rest = Alternative(NOT_ON_THE_LIST, {}, 1 - probability - 0.02)
    cause, sizes = StiffnessChange((3,), 0.7), {"factor": Parameter(0.7012, 0.0034, "1")}
    names = tuple(recording.name for recording in dataset.select("train"))
    sentence = sentence_of(cause, sizes, chain())
    return Finding(cause, sizes, probability, 0.9, names, (rival, rest), sentence)


def example_of(dataset: Dataset) -> Example:
    """Return the recording for testing, forecast badly by the drawn structure, and well with what was found."""
    (recording,) = dataset.select("test")
    first = recording.data.shape[1] // 5
    measured = recording.data[0, first:]
    rng = np.random.default_rng(0)
    noise = FLOOR * np.ptp(measured, axis=0) * rng.standard_normal(measured.shape)
    frequencies = fe.natural_modes(chain(), 5).frequencies
    both = (0.5 * measured, measured + noise)
    return Example(recording.name, RATE, first / RATE, dataset.sensors, measured, *both, frequencies)


def answer_by_modes(dataset: Dataset, *findings: Finding, verdict: Verdict = Verdict.EXPLAINED) -> ModalDiagnosis:
    """Return an answer by modes and motion with these findings."""
    sensors = dataset.sensors
    own = tuple(number for number, sensor in enumerate(sensors) if sensor.role == "measured")
    noise = NoiseModel(tuple(sensors[number] for number in own), RATE, np.ones(len(own)))
    roles = SensorRoles(sensors, own, noise)
    ones = np.ones((1, len(sensors)))
    before, after = (ForecastScore(error * ones, FLOOR * ones, 100.0 * error, 1.0) for error in (BEFORE, AFTER))
    forecasts = MotionForecasts(before, after, example_of(dataset), roles)
    names = tuple(recording.name for recording in dataset.recordings)
    states = tuple(State((name,), (1.0, 2.9), (0.001, 0.002), (0.01, 0.011)) for name in names)
    modes = (
        PairedMode(names[0], 1.0012, 0.0013, 0.0101, 0.0002, 1.05, 1.0011, 0.98, 0.999),
        PairedMode(names[0], 2.9, 0.002, 0.011, 0.0003, None, None, None, None),
    )
    extended = dataset.model
    assert isinstance(extended, fe.Structure)
    extended = extended.with_effects(*(finding.cause for finding in findings if isinstance(finding.cause, Effect)))
    calibration = (Calibrated("stiffness", {"element": 1}, 1.01, 0.004),)
    return ModalDiagnosis(
        verdict,
        findings,
        calibration,
        0.02,
        states,
        modes,
        extended,
        ("a note of <b>weight</b>",),
        2.0,
        True,
        forecasts,
        0,
        competed=("added_mass", "cubic_spring", "stiffness_change"),
    )


def answer_by_series(dataset: Dataset, *findings: Finding, verdict: Verdict = Verdict.EXPLAINED) -> Diagnosis:
    """Return an answer by time series with these findings, what would tell them from a rival, and two hypotheses."""
    other = answer_by_modes(dataset, *findings)
    modal = fe.natural_modes(chain(), 5)
    modes = Modes(modal.frequencies, modal.damping_ratio, modal.shapes)
    shares, errors = np.full(5, 0.2), np.full((3, len(dataset.sensors)), 0.1)
    levels = np.where([sensor.role == "measured" for sensor in dataset.sensors], 0.01, np.nan)
    shown = Observations(modes, modes, modes, np.ones(5), shares, shares, None, dataset.sensors, errors, levels, levels)
    rival = SimpleNamespace(kind="cubic_spring", reported_location={"node": 4, "direction": "x"})
    fits = [
        SimpleNamespace(hypothesis=SimpleNamespace(candidates=candidates), chi2=chi2, values=1000.0)
        for candidates, chi2 in (((rival,), 1e3), ((), 5e3))
    ]
    posterior = Posterior(cast(tuple[Fit, ...], tuple(fits)), np.array([0.99, 0.01]), 1.0, 1.0)
    causes = (
        Cause("stiffness_change", {"element": 3}, 0.6),
        Cause("cubic_spring", {"node": 4, "direction": "x"}, 0.3),
    )
    options = (
        Option(Measurement("sensor", 2, "x", "acceleration"), 0.9, 0.97),
        Option(Measurement("hammer", 4, "x"), 0.7, 0.93),
    )
    then = NextMeasurement(options, causes, 0.6, ()) if findings else None
    assert isinstance(other.extended, fe.Structure)
    return Diagnosis(
        verdict,
        findings,
        other.calibration,
        0.02,
        other.scores,
        FLOOR,
        other.extended,
        shown,
        example_of(dataset),
        then,
        posterior,
        True,
        ("a note",),
        2.0,
    )


def write(folder: Path, html: str) -> Path:
    """Write a page into a folder."""
    path = folder / "report.html"
    path.write_text(html, encoding="utf-8")
    return path
