"""A diagnosis in a folder: whatever fails after the report, the report stays, and nothing old stands beside it."""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NoReturn, cast

import pytest
from typer.testing import CliRunner

from fe_models.built_in.four_dof import four_dof
from fe_models.files.dataset_file import save_dataset
from fe_models.files.result_list import LIST_FILE
from fe_models.files.structure_file import load_structure
from hybrid.diagnosis import report_files
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.report_files import add_gain, save_diagnosis
from hybrid.diagnosis.track_record.certified import Share
from hybrid.diagnosis.track_record.trust import Trust
from hybrid.result_sets import EXTENDED, PICTURE, REPORT, SUMMARY, diagnosis_in
from scripts.diagnose import app
from tests.hybrid_problems import chain_dataset


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> Diagnosis:
    """A diagnosis whose report, words and picture are its verdict."""
    monkeypatch.setattr(report_files, "answer_table", lambda found, gain: {"verdict": found.verdict, "gain": gain})
    monkeypatch.setattr(report_files, "answer_in_words", lambda found, gain: f"{found.verdict}, gain {gain}")
    monkeypatch.setattr(
        report_files, "draw_example", lambda example: SimpleNamespace(save=lambda path: path.write_text(example))
    )
    return cast(Diagnosis, SimpleNamespace(verdict="first", extended=four_dof(), example="first"))


def second() -> Diagnosis:
    return cast(Diagnosis, SimpleNamespace(verdict="second", extended=four_dof().refined(1), example="second"))


def failing(*arguments: object) -> NoReturn:
    raise ZeroDivisionError("no way")


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} - {LIST_FILE}


def report(folder: Path) -> dict[str, Any]:
    content: dict[str, Any] = json.loads((folder / REPORT).read_text())
    return content


def test_the_summary_is_what_is_printed(found: Diagnosis, tmp_path: Path) -> None:
    save_diagnosis(found, tmp_path)
    assert names(tmp_path) == {REPORT, SUMMARY, EXTENDED, PICTURE}
    assert (tmp_path / SUMMARY).read_text() == "first, gain None\n"
    assert load_structure(tmp_path / EXTENDED) == four_dof()
    add_gain(found, cast(Any, 0.5), tmp_path)
    assert (tmp_path / SUMMARY).read_text() == "first, gain 0.5\n"
    assert report(tmp_path) == {"verdict": "first", "gain": 0.5}
    assert names(tmp_path) == {REPORT, SUMMARY, EXTENDED, PICTURE}


@pytest.mark.parametrize(
    ("step", "missing"),
    [("draw_example", PICTURE), ("save_structure", EXTENDED)],
)
def test_a_failure_after_the_report_leaves_the_new_report_with_nothing_older(
    step: str, missing: str, found: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert save_diagnosis(found, tmp_path) == []
    with monkeypatch.context() as patch:
        patch.setattr(report_files, step, failing)
        (note,) = save_diagnosis(second(), tmp_path)
    assert report(tmp_path)["verdict"] == "second"
    assert names(tmp_path) == {REPORT, SUMMARY, EXTENDED, PICTURE} - {missing}
    assert note == f"{tmp_path / missing} could not be made (ZeroDivisionError: no way); the report is complete"
    save_diagnosis(second(), tmp_path)
    assert (tmp_path / PICTURE).read_text() == "second"


def test_a_report_that_cannot_be_written_leaves_the_older_diagnosis(
    found: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    save_diagnosis(found, tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    monkeypatch.setattr(report_files, "answer_in_words", failing)
    with pytest.raises(ZeroDivisionError):
        save_diagnosis(second(), tmp_path)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_diagnosis_leaves_the_training_in_its_folder_alone(found: Diagnosis, tmp_path: Path) -> None:
    (tmp_path / "checkpoint.pt").write_text("trained")
    diagnosis_in(tmp_path).check([tmp_path / "checkpoint.pt"])
    save_diagnosis(found, tmp_path)
    assert (tmp_path / "checkpoint.pt").read_text() == "trained"


def test_a_picture_that_fails_is_a_note_and_the_command_ends_well(
    found: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The exit status is 0 once a report is written."""
    monkeypatch.setattr("hybrid.diagnosis.diagnosis.diagnose", lambda data, advance: found)
    monkeypatch.setattr("hybrid.diagnosis.report.describe_diagnosis", lambda found, gain: "the answer")
    trust = Trust(Share(9, 10, (0.6, 0.98)), "Nine of ten", "certificate")
    monkeypatch.setattr("hybrid.diagnosis.track_record.trust.trust_in", lambda data, found: trust)
    monkeypatch.setattr(report_files, "draw_example", failing)
    dataset = save_dataset(chain_dataset(), tmp_path / "data", "four_dof")
    result = CliRunner().invoke(app, [str(dataset), "--out", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    assert "the answer" in result.stdout
    assert result.stderr.startswith(f"note: {tmp_path / 'out' / PICTURE} could not be made")
    assert names(tmp_path / "out") == {REPORT, SUMMARY, EXTENDED}
