"""The page of a diagnosis, from the answer in a sentence to what was assumed."""

from collections.abc import Sequence
from pathlib import Path

from fe_models.linear import LinearModel
from fe_models.recordings import Dataset
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.learned.gain import Gain
from hybrid.diagnosis.track_record.trust import trust_in
from hybrid.report.answer import facts_of, next_steps, sentence_of, summary_of, verdict_of
from hybrid.report.assumed_section import what_was_assumed
from hybrid.report.badge import badge_of
from hybrid.report.evidence_section import why_believe_it
from hybrid.report.forecast_section import how_much_better
from hybrid.report.page import Page
from hybrid.report.provenance import Provenance, provenance_of, written_by
from hybrid.report.seen import Seen, seen_in
from hybrid.report.unknown_section import what_is_not_known
from hybrid.report.where import where

SEED = (
    "starting values, orders of recordings and data of possible measurements are drawn from the same seeds each time,"
    " so that the same inputs give the same answer"
)


def diagnosis_page(
    found: Answer, dataset: Dataset, seen: Seen, provenance: Provenance, gain: Gain | None = None
) -> Page:
    """Return the page of an answer about a ``dataset``, with what was ``seen`` in some of its recordings by themselves;
    ``gain``: what was learned on top, where it was.
    """
    verdict, tone = verdict_of(found)
    name = "imported matrices" if isinstance(dataset.model, LinearModel) else dataset.model.name
    sections = (
        where(found, dataset),
        how_much_better(found, dataset, gain),
        why_believe_it(found, seen),
        what_is_not_known(found),
        what_was_assumed(dataset, provenance, found),
    )
    return Page(
        title=f"Diagnosis of {name}",
        verdict=verdict,
        tone=tone,
        sentence=sentence_of(found, dataset),
        summary=summary_of(found),
        facts=facts_of(found),
        next=next_steps(found),
        sections=sections,
        footer=written_by(provenance),
        badge=badge_of(trust_in(dataset, found)),
    )


def page_from_files(
    found: Answer, dataset: Dataset, command: Sequence[str], file: Path, gain: Gain | None = None
) -> Page:
    """Return the page of an answer about the ``dataset`` of a ``file``, by the words of a ``command``."""
    source = provenance_of(command, file, SEED, found.seconds)
    return diagnosis_page(found, dataset, seen_in(dataset, found), source, gain)
