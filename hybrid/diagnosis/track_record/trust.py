"""How often answers like one were right in the certificate, in words and numbers."""

from dataclasses import dataclass
from typing import Any

from fe_models.recordings import Dataset
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.probability import two_decimals
from hybrid.diagnosis.track_record.certified import Bin, Certified, Column, Share, certified
from hybrid.diagnosis.track_record.likeness import column_like, kind_of, words_of

LEAST = 10  # cases: of fewer, all right, the 95 % interval begins below 70 %
NOT_KNOWN = "How often answers like this one are right is not known yet"
FEW = "of {what} on {like} the certificate has {count}"
TOO_FEW = "too few to tell"
RIGHT_IN = "Answers like this one were right in {hits} of {count} simulated cases ({interval}, 95 % interval)."
RIGHT = "{What} was right {hits} of {count} times on {like}"
NOT_YOURS = "Simulated structures are simpler than a real one: expect rather less of yours."
VERDICTS = {
    Verdict.NOTHING_WRONG: "the answer that nothing is wrong",
    Verdict.EXPLAINED: "the answer that calibration explains it",
    Verdict.PARTLY_EXPLAINED: "the answer that a part is explained",
    Verdict.UNEXPLAINED: "the answer that nothing on the list explains it",
}


@dataclass(frozen=True)
class Trust:
    """``right``: how many answers like one were, None where that is not known; a ``sentence`` that says so; ``source``:
    the certificate that it is from; ``cases``: how many are too few to know it, None where none are like it.
    """

    right: Share | None
    sentence: str
    source: str
    cases: int | None = None

    @property
    def line(self) -> str:
        """The same in a short line of the terminal."""
        if self.right is not None:
            return RIGHT_IN.format(hits=self.right.hits, count=self.right.count, interval=percent(self.right))
        if self.cases is None:
            return f"{self.sentence}."
        return f"{NOT_KNOWN} ({self.cases or 'no'} case{'' if self.cases == 1 else 's'})."

    def as_json(self) -> dict[str, Any]:
        """Return the same as plain data."""
        known = None if self.right is None else vars(self.right)
        return {"right": known, "sentence": self.sentence, "source": self.source}


def trust_in(dataset: Dataset, found: Answer, known: Certified | None = None) -> Trust:
    """Return how often answers like the one ``found`` in a ``dataset`` were right; ``known``: what was counted, that
    which is installed where it is left out.
    """
    known = known or certified()
    kind = kind_of(dataset, found)
    column = kind if isinstance(kind, str) else column_like(kind, known)
    if isinstance(column, str):
        return Trust(None, f"{NOT_KNOWN}: {column}", _source(known))
    what, share = _counted(found, column)
    like, source = words_of(column), _source(known, column)
    if share.count < LEAST:
        count = f"{share.count} so far, {TOO_FEW}" if share.count else "none so far"
        told = FEW.format(what=what, like=like, count=count)
        return Trust(None, f"{NOT_KNOWN}: {told}", source, share.count)
    told = RIGHT.format(What=what[:1].upper() + what[1:], hits=share.hits, count=share.count, like=like)
    return Trust(share, told, source)


def percent(share: Share) -> str:
    """Return the interval of a share in per cent."""
    low, high = share.interval
    return f"{100 * low:.0f} to {100 * high:.0f} %"


def _counted(found: Answer, column: Column) -> tuple[str, Share]:
    """Return what is counted that is like an answer, in words, and how often it was right."""
    nothing = Share(0, 0, (0.0, 1.0))
    groups = found.groups if isinstance(found, ModalDiagnosis) else 0
    if not found.findings:
        return VERDICTS[found.verdict], column.answers.get(found.verdict.value, nothing)
    if groups == len(found.findings):
        return "the factor of a group that is off", column.groups
    p = found.findings[0].probability
    own = next((item for item in column.named if item.low <= p < item.high or p == item.high == 1.0), None)
    if own is None:
        return f"what was named at {two_decimals(p)}", nothing
    return f"what was named {_span(own)}", own.right


def _span(own: Bin) -> str:
    if own.low == 0.0:
        return f"below {own.high:g}"
    return f"at {own.low:g} or more" if own.high == 1.0 else f"at {own.low:g} to {own.high:g}"


def _source(known: Certified, column: Column | None = None) -> str:
    changed = " with changes that are not committed" if known.changes else ""
    days = f", {known.days[-1]}" if known.days else ""
    done = "" if column is None else f"; {column.done} of {column.planned} cases of this kind have run"
    return f"certificate of commit {known.commit[:12]}{changed}{days}{done}"
