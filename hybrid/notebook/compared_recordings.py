"""A comparison of recordings as a notebook has it."""

from dataclasses import dataclass
from html import escape
from pathlib import Path

from fe_models.files.atomic import write_text
from hybrid.identification.comparison_files import save_comparison
from hybrid.identification.dataset_comparison import DatasetComparison
from hybrid.identification.frequency_response import FrequencyResponse
from hybrid.identification.recording_comparison import Compared
from hybrid.result_sets import comparison_in


@dataclass(frozen=True, repr=False)
class ComparedRecordings:
    """What `hybrid.compare_recordings` returns; the ``comparison`` holds all that it is made of."""

    comparison: DatasetComparison

    @property
    def modes(self) -> Compared | None:
        """Modes of recordings that move freely or under unknown forces; None where forces are known in all."""
        return self.comparison.compared

    @property
    def responses(self) -> FrequencyResponse | None:
        """Frequency response functions of recordings under known forces; None where there are none."""
        return self.comparison.responses

    def save(self, folder: str | Path) -> Path:
        """Write tables and pictures into ``folder``, as the command does; return it.

        `InputError` where that would write over a file of yours.
        """
        comparison_in(Path(folder)).check()
        save_comparison(self.comparison, Path(folder))
        return Path(folder)

    def to_html(self, path: str | Path) -> Path:
        """Write the comparison as a page that any browser shows, the same as the command's; return its path."""
        from hybrid.report.comparison_page import SEED, comparison_page  # draws, which only pages need
        from hybrid.report.provenance import in_python
        from hybrid.report.rendering import rendered

        source = in_python("hybrid.compare_recordings(design, data)", SEED, self.comparison.seconds)
        write_text(Path(path), rendered(comparison_page(self.comparison, source)))
        return Path(path)

    def __repr__(self) -> str:
        return "\n".join([*(f"Note: {note}." for note in self.comparison.notes), self.comparison.text])

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>"
