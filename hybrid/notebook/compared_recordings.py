"""A comparison of recordings as a notebook has it."""

from dataclasses import dataclass
from html import escape
from pathlib import Path

from fe_models.recordings import Dataset
from hybrid.identification.comparison_files import save_comparison
from hybrid.identification.comparison_report import describe_compared
from hybrid.identification.recording_comparison import Compared
from hybrid.result_sets import comparison_in


@dataclass(frozen=True, repr=False)
class ComparedRecordings:
    """What `hybrid.compare_recordings` returns; ``compared`` holds all that its tables show of the ``dataset``."""

    compared: Compared
    dataset: Dataset

    def save(self, folder: str | Path) -> Path:
        """Write tables and pictures into ``folder``, as the command does; return it.

        `InputError` where that would write over a file of yours.
        """
        comparison_in(Path(folder)).check()
        save_comparison(self.compared, self.dataset, Path(folder))
        return Path(folder)

    def __repr__(self) -> str:
        return describe_compared(self.compared)

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>"
