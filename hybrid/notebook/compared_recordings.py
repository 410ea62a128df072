"""A comparison of recordings as a notebook has it."""

from dataclasses import dataclass
from html import escape

from hybrid.identification.comparison_report import describe_compared
from hybrid.identification.recording_comparison import Compared


@dataclass(frozen=True, repr=False)
class ComparedRecordings:
    """What `hybrid.compare_recordings` returns; ``compared`` holds all that its tables show."""

    compared: Compared

    def __repr__(self) -> str:
        return describe_compared(self.compared)

    def _repr_html_(self) -> str:
        return f"<pre>{escape(repr(self))}</pre>"
