"""A diagnosis in a folder: its report first, then the extended structure, then the picture, which may fail."""

from pathlib import Path

from fe_models.files.atomic import write_json, write_text
from fe_models.files.structure_file import save_structure
from hybrid.diagnosis.learned.gain import Gain
from hybrid.diagnosis.observed.example import draw_example
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.report import describe_diagnosis, report_table
from hybrid.result_sets import EXTENDED, PICTURE, REPORT, SUMMARY, diagnosis_in


def save_diagnosis(found: Diagnosis, folder: Path) -> None:
    """Replace the older diagnosis in ``folder``, none of whose files stays beside the new report.

    Whatever fails after the report, it stays: minutes of search must not be lost for a picture.
    """
    results = diagnosis_in(folder)
    with results.replacing() as new:
        _write_report(found, None, new)
    with results.adding() as new:
        save_structure(found.extended, new / EXTENDED)
    with results.adding() as new:
        draw_example(new / PICTURE, found.example)


def add_gain(found: Diagnosis, gain: Gain, folder: Path) -> None:
    """Write the report in ``folder`` again, with what was learned on top."""
    with diagnosis_in(folder).adding() as new:
        _write_report(found, gain, new)


def _write_report(found: Diagnosis, gain: Gain | None, folder: Path) -> None:
    write_json(folder / REPORT, report_table(found, gain))
    write_text(folder / SUMMARY, describe_diagnosis(found, gain) + "\n")
