"""A diagnosis in a folder: its report first, then the extended structure, then the picture, which may fail."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from fe_models.files.atomic import write_json, write_text
from fe_models.files.structure_file import save_structure
from hybrid.diagnosis.answer import Answer, answer_in_words, answer_table
from hybrid.diagnosis.learned.gain import Gain
from hybrid.diagnosis.modal_report import draw_modes
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.observed.example import draw_example
from hybrid.diagnosis.outcome.extend_matrices import ExtendedMatrices, save_extended_matrices
from hybrid.diagnosis.track_record.trust import Trust
from hybrid.result_sets import EXTENDED, EXTENDED_MATRICES, MODES, PICTURE, REPORT, SUMMARY, diagnosis_in


def save_diagnosis(found: Answer, folder: Path, trust: Trust | None = None) -> list[str]:
    """Replace the older diagnosis in ``folder``; return a note on each file that could not be made after the report.

    ``trust``: how often answers like it were right, where that is to be told.
    """
    makers: dict[str, Callable[[Path], object]] = {EXTENDED: lambda path: _save_extended(found, path)}
    example = found.example
    if example is not None:
        makers[PICTURE] = lambda path: draw_example(example).save(path)
    if isinstance(found, ModalDiagnosis):
        makers[MODES] = lambda path: draw_modes(found.modes).save(path)
    return saved(folder, lambda new: _write_report(found, None, trust, new), makers)


def _save_extended(found: Answer, path: Path) -> None:
    if isinstance(found.extended, ExtendedMatrices):
        save_extended_matrices(found.extended, path, path.with_name(EXTENDED_MATRICES))
    else:
        save_structure(found.extended, path)


def saved(
    folder: Path, write_report: Callable[[Path], object], makers: Mapping[str, Callable[[Path], object]]
) -> list[str]:
    """Replace the older diagnosis in ``folder``, none of whose files stays beside the new report.

    Return a note on each file that could not be made after the report: minutes of search must not be lost for a
    picture, and whoever has a report has the answer. ``makers``: of each other file by its name.
    """
    results, notes = diagnosis_in(folder), list[str]()
    with results.replacing() as new:
        write_report(new)
    for name, make in makers.items():
        try:
            with results.adding() as new:
                make(new / name)
        except Exception as error:  # graphics fail in many ways, and none of them is the report's
            reason = " ".join(str(error).split())
            notes.append(
                f"{folder / name} could not be made ({type(error).__name__}: {reason}); the report is complete"
            )
    return notes


def add_gain(found: Answer, gain: Gain, folder: Path, trust: Trust | None = None) -> None:
    """Write the report in ``folder`` again, with what was learned on top."""
    with diagnosis_in(folder).adding() as new:
        _write_report(found, gain, trust, new)


def report_content(found: Answer, gain: Gain | None, trust: Trust | None) -> dict[str, Any]:
    """Return what ``report.json`` has."""
    return answer_table(found, gain) | ({} if trust is None else {"track_record": trust.as_json()})


def _write_report(found: Answer, gain: Gain | None, trust: Trust | None, folder: Path) -> None:
    lines = [answer_in_words(found, gain)] + ([] if trust is None else [trust.line])
    write_json(folder / REPORT, report_content(found, gain, trust))
    write_text(folder / SUMMARY, "\n".join(lines) + "\n")
