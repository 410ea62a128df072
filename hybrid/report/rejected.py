"""What was rejected, and why: the hypotheses that competed, how probable each is, and what it leaves unexplained."""

from collections.abc import Iterator, Sequence

from fe_models.causes.base import CAUSES
from fe_models.causes.wording import at_place, kind_words
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.modes_and_motion.considered import MAX_TOLD, ConsideredHypothesis
from hybrid.diagnosis.probability import per_cent
from hybrid.report.page import Block, Cell, Paragraph, Table
from hybrid.report.values import number, share

COMPETED = "Competed, each at all its places: {kinds}."
NONE_REJECTED = "None but those that are named has a probability worth a line."
HYPOTHESIS, PROBABILITY = "hypothesis", "probability"
EQUAL = " Equally good fits differ by how exactly their sizes had to be chosen and by how many causes they need."
LEFT_OF_RECORDINGS = "Left: what the best fit leaves of the recordings, over what noise would; 1 is noise alone."
LEFT_OF_MODES = (
    "Left: what the best fit leaves of frequencies, damping ratios and shapes (mean square), over what modes of one"
    " structure differ by from one recording to the next; 1 is chance alone."
)
LEFT_OF_MOTION = (
    "Left: what the law leaves of the motion that the structure's modes do not follow, a radian of their vibration. The"
    " right law leaves some thousandths; one that only resembles it leaves more."
)


def rejected(found: Answer) -> Iterator[Block]:
    """Return which causes competed, and the likeliest hypotheses."""
    every = found.competed if isinstance(found, ModalDiagnosis) else tuple(CAUSES)
    kinds = ", ".join(sorted(map(kind_words, every), key=str.lower))
    yield Paragraph(COMPETED.format(kinds=kinds))
    tables = _by_modes(found) if isinstance(found, ModalDiagnosis) else _by_series(found.posterior)
    if tables:
        yield from tables
    elif not any(finding.alternatives for finding in found.findings):
        yield Paragraph(NONE_REJECTED)


def _by_series(posterior: Posterior) -> list[Table]:
    """Return the most probable hypotheses that were held against every sample."""
    if len(posterior.fits) < 2:
        return []
    fits = list(zip(posterior.fits, posterior.probability.tolist(), strict=True))
    nothing = [pair for pair in fits[MAX_TOLD:] if not pair[0].hypothesis.candidates]
    rows = tuple(
        (Cell(_claim(fit)), Cell(per_cent(own), own), number(fit.chi2 / max(fit.values, 1.0)))
        for fit, own in [*fits[:MAX_TOLD], *nothing]
    )
    caption = f"The likeliest of {len(fits)} hypotheses that were fitted to the end."
    return [Table(caption, (HYPOTHESIS, PROBABILITY, "left"), rows, LEFT_OF_RECORDINGS + EQUAL)]


def _claim(fit: Fit) -> str:
    own = [f"{kind_words(item.kind)} {at_place(item.reported_location)}" for item in fit.hypothesis.candidates]
    return " and ".join(own) or "nothing is wrong"


def _by_modes(found: ModalDiagnosis) -> list[Table]:
    """Return the most probable hypotheses that were held against modes, then force laws against the motion."""
    tables = []
    if len(found.considered) > 1:
        caption = "The likeliest hypotheses of those that were held against the measured modes."
        tables.append(_considered(caption, found.considered, LEFT_OF_MODES + EQUAL, is_share=False))
    if len(found.considered_laws) > 1:
        caption = "The likeliest force laws of those that were held against the motion."
        tables.append(_considered(caption, found.considered_laws, LEFT_OF_MOTION, is_share=True))
    return tables


def _considered(caption: str, some: Sequence[ConsideredHypothesis], note: str, is_share: bool) -> Table:
    rows = tuple(
        (
            Cell(own.words),
            Cell(per_cent(own.probability), own.probability),
            share(own.leaves) if is_share else number(own.leaves),
        )
        for own in some
    )
    return Table(caption, (HYPOTHESIS, PROBABILITY, "left"), rows, note)
