"""What a diagnosis answers, whichever search found it, as data and in words."""

from typing import Any

from hybrid.diagnosis import modal_report, report
from hybrid.diagnosis.learned.gain import Gain
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.outcome.conclusion import Diagnosis

Answer = Diagnosis | ModalDiagnosis


def answer_table(found: Answer, gain: Gain | None = None) -> dict[str, Any]:
    """Return the report as plain data, ready for JSON; ``gain``: what was learned on top, where it was."""
    if isinstance(found, ModalDiagnosis):
        return modal_report.modal_table(found, gain)
    return report.report_table(found, gain)


def answer_in_words(found: Answer, gain: Gain | None = None) -> str:
    """Return the report in lines: what the drawn structure shows, and what that amounts to."""
    if isinstance(found, ModalDiagnosis):
        return modal_report.describe_modal(found, gain)
    return report.describe_diagnosis(found, gain)


def summary_of(found: Answer) -> str:
    """Return the answer alone in lines: headline, findings with their rivals, forecasts before and after, notes."""
    return modal_report.modal_summary(found) if isinstance(found, ModalDiagnosis) else report.summary(found)


def measure_of_left(found: Answer) -> str:
    """Return of what a share is left unexplained, in a standard term."""
    return modal_report.measure_of_left(found) if isinstance(found, ModalDiagnosis) else report.ERROR_ENERGY


def measure_of_explained(found: Answer) -> str:
    """Return of what each finding explains a share, in standard terms."""
    if isinstance(found, ModalDiagnosis):
        return f"{modal_report.MISFIT}, or, of a force law, {modal_report.DISCREPANCY_ENERGY}"
    return report.ERROR_ENERGY


def headline_of(found: Answer) -> str:
    """Return the answer in one sentence."""
    return modal_report.headline(found) if isinstance(found, ModalDiagnosis) else report.headline(found)
