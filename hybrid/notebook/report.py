"""A diagnosis as a notebook has it: it prints itself, and is saved as a page or as what the command writes."""

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fe_models.files.atomic import write_text
from fe_models.html import html_paragraph, html_table
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.diagnosis.answer import Answer, headline_of, summary_of
from hybrid.diagnosis.outcome.extend_matrices import ExtendedMatrices
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.probability import two_decimals
from hybrid.diagnosis.report import next_lines, rival_words
from hybrid.diagnosis.report_files import report_content, save_diagnosis
from hybrid.diagnosis.track_record.trust import Trust, trust_in
from hybrid.result_sets import diagnosis_in


@dataclass(frozen=True, repr=False)
class Report:
    """What `hybrid.diagnose` returns of a ``dataset``; the ``diagnosis`` holds all that it is made of; ``by_modes``:
    whether that was asked for.
    """

    diagnosis: Answer
    dataset: Dataset
    by_modes: bool = False

    @property
    def verdict(self) -> Verdict:
        """The answer in a word: nothing wrong, explained, partly explained or unexplained."""
        return self.diagnosis.verdict

    @property
    def findings(self) -> tuple[Finding, ...]:
        """The causes that are named, with parameters, probabilities and rivals; what explains most first."""
        return self.diagnosis.findings

    @property
    def extended(self) -> Structure | ExtendedMatrices:
        """The design with the findings built in and its nominal values calibrated."""
        return self.diagnosis.extended

    @property
    def scores(self) -> dict[str, dict[str, float | None]]:
        """NRMSE of forecasts by the design, "baseline", and by the extended structure, measured and held-out."""
        return self.diagnosis.scores

    @property
    def trust(self) -> Trust:
        """How often answers like this one were right in the certificate."""
        return trust_in(self.dataset, self.diagnosis)

    def __repr__(self) -> str:
        return summary_of(self.diagnosis)

    def _repr_html_(self) -> str:
        parts = [html_paragraph(headline_of(self.diagnosis))]
        if self.findings:
            header = ("what is wrong", "probability", "explains", "cannot be ruled out")
            parts.append(html_table(header, (_row(finding) for finding in self.findings)))
        rows = [(name, *(_score(scores[role]) for role in ("measured", "held_out"))) for name, scores in self._scores()]
        parts.append(html_table(("forecast NRMSE", "measured", "held out"), rows))
        parts += [html_paragraph(line) for line in next_lines(self.diagnosis.next_measurement)]
        parts += [html_paragraph(f"Note: {note}.") for note in self.diagnosis.notes]
        return "\n".join(parts)

    def save(self, folder: str | Path) -> Path:
        """Write report, summary, extended structure and a picture into ``folder``, as the command does; return it.

        `InputError` where that would write over a file of yours; a warning where all but the report failed.
        """
        diagnosis_in(Path(folder)).check()
        for note in save_diagnosis(self.diagnosis, Path(folder), self.trust):
            warnings.warn(note, stacklevel=2)
        return Path(folder)

    def to_html(self, path: str | Path) -> Path:
        """Write the report as a page that any browser shows, the same as the command's; return its path."""
        from hybrid.report.diagnosis_page import SEED, diagnosis_page  # draws, which only pages need
        from hybrid.report.provenance import in_python
        from hybrid.report.rendering import rendered
        from hybrid.report.seen import seen_in

        seen = seen_in(self.dataset, self.diagnosis)
        call = f"hybrid.diagnose(design, data{', by_modes=True' if self.by_modes else ''})"
        source = in_python(call, SEED, self.diagnosis.seconds)
        write_text(Path(path), rendered(diagnosis_page(self.diagnosis, self.dataset, seen, source)))
        return Path(path)

    def table(self) -> dict[str, Any]:
        """Return the report as plain data, as ``report.json`` of the command has it."""
        return report_content(self.diagnosis, None, self.trust)

    def _scores(self) -> list[tuple[str, dict[str, float | None]]]:
        before, after = self.scores["baseline"], self.scores["extended"]
        floor: dict[str, float | None] = {"measured": self.diagnosis.noise_floor, "held_out": None}
        return [("design", before), ("extended", after), ("noise floor", floor)]


def _row(finding: Finding) -> tuple[str, str, str, str]:
    rivals = "; ".join(f"{rival_words(item)} ({two_decimals(item.probability)})" for item in finding.alternatives)
    return finding.sentence, two_decimals(finding.probability), f"{finding.explains:.0%}", rivals or "-"


def _score(score: float | None) -> str:
    return "-" if score is None else f"{score:.4f}"
