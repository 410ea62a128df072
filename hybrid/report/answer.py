"""The answer of a diagnosis in one sentence with its probability, and what to do next."""

from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.diagnosis.answer import Answer, headline_of
from hybrid.diagnosis.config import REPORT, SEARCH_CHOICE
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.probability import per_cent
from hybrid.report.page import Tone
from hybrid.report.values import of_parameter, percentage, sentence, typeset
from hybrid.result_sets import EXTENDED

VERDICTS = {
    Verdict.NOTHING_WRONG: ("Nothing is wrong", Tone.GOOD),
    Verdict.EXPLAINED: ("Something is wrong, and it is explained", Tone.FOUND),
    Verdict.PARTLY_EXPLAINED: ("Something is wrong, and a part of it is explained", Tone.OPEN),
    Verdict.UNEXPLAINED: ("Something is wrong, and it is not explained", Tone.BAD),
}
NOT_SURE = "Something is wrong, and several causes remain"
SEVERAL = "What was found explains what is wrong, but the sensors do not tell it from its rivals surely enough."
USE_AS_IT_IS = "Use the model as it is; how far nominal values may be moved is listed under “What was assumed”."
LOOK_THERE = "Look at the structure there, and use {model} for further analyses: the structure with what was found."
NOT_YET = "Do not act on the likeliest cause alone: check the others under “What is not known”, too."
MORE_DATA = "Record larger motions, or more of them, or add a sensor near the places marked below."
WORSE = "Do not forecast with it yet: recordings that were never fitted are forecast worse than by the model as drawn."
PART_ONLY = "Look for what else is wrong where most of the error is left: see “What is not known”."
ELSEWHERE = (
    "Check what is on no list of causes: the units, places and directions of sensors, and whether the model is the"
    " structure that was measured."
)


def verdict_of(found: Answer) -> tuple[str, Tone]:
    """Return how a diagnosis ended, in a few words."""
    if found.verdict is Verdict.EXPLAINED and not _is_sure(found):
        return NOT_SURE, Tone.OPEN
    return VERDICTS[found.verdict]


def sentence_of(found: Answer, dataset: Dataset) -> str:
    """Return the answer in one sentence with its probability."""
    if not found.findings:
        return headline_of(found)
    first = found.findings[0]
    told = f"{_said(first, dataset)} (probability: {per_cent(first.probability)})."
    if first.probability < REPORT.min_named_probability:
        told = f"Likeliest of several causes: {_within(told)}"
    elif first.probability < SEARCH_CHOICE.sure_probability:
        told = f"Probably {_within(told)}"
    told = told if len(found.findings) == 1 else f"{_counted(found)}. First: {told}"
    return told.replace(" %", "\u00a0%")  # where no line shall break


def _counted(found: Answer) -> str:
    """Return how many causes were found, and how many groups are merely off."""
    groups = found.groups if isinstance(found, ModalDiagnosis) else 0
    causes = len(found.findings) - groups
    off = f"{_words(groups)} group{' is' if groups == 1 else 's are'} off by more than was stated"
    wrong = f"{_words(causes)} thing{' is' if causes == 1 else 's are'} wrong"
    if not groups:
        return wrong
    return off if not causes else f"{wrong}, and {_within(off)}"


def _within(told: str) -> str:
    """Return a sentence as it goes on after a first word."""
    return told[:1].lower() + told[1:]


def _said(finding: Finding, dataset: Dataset) -> str:
    """Return what a finding says, with sizes to two digits of their uncertainty, and where it acts in a part alone."""
    if not isinstance(dataset.model, Structure):
        return typeset(finding.sentence).rstrip(".")
    sizes = {word: of_parameter(item) for word, item in finding.parameters.items()}
    told = typeset(finding.cause.sentence(sizes, dataset.model)).rstrip(".")
    own = list(dict.fromkeys(finding.recordings))
    return f"{told}, in {', '.join(own)} alone" if own and not fitted_names(dataset) <= set(own) else told


def fitted_names(dataset: Dataset) -> set[str]:
    """Return the names of the recordings, or states, that were fitted."""
    recordings = {recording.name for recording in dataset.select("train")}
    return recordings | {mode.recording for mode in dataset.modes if mode.role == "train"}


def summary_of(found: Answer) -> str:
    """Return what that amounts to; nothing where the sentence says it all."""
    if not found.findings:
        return ""
    if verdict_of(found)[0] == NOT_SURE:
        return SEVERAL
    return headline_of(found).replace("named below", "named above")  # which is where a page has it


def facts_of(found: Answer) -> tuple[tuple[str, str], ...]:
    """Return the numbers that matter most, each with its name."""
    facts = list[tuple[str, str]]()
    if found.findings:
        name = "probability" if len(found.findings) == 1 else "probability of the first"
        facts.append((name, per_cent(found.findings[0].probability)))
    before, after = (found.scores[name]["measured"] for name in ("baseline", "extended"))
    if before is not None and after is not None:
        name = "forecast error, before → after" if found.findings else "forecast error, as drawn → calibrated"
        facts.append((name, f"{before:.4f} → {after:.4f}"))
    if found.noise_floor is not None:
        facts.append(("noise floor", f"{found.noise_floor:.4f}"))
    if found.findings:
        facts.append(("left unexplained", percentage(found.unexplained)))
    return tuple(facts)


def next_steps(found: Answer) -> tuple[str, ...]:
    """Return what to do next, most useful first."""
    then = found.next_measurement
    advice = () if then is None else tuple(map(sentence, then.sentences[:1]))
    if found.verdict is Verdict.NOTHING_WRONG:
        return (USE_AS_IT_IS,)
    if found.verdict is Verdict.UNEXPLAINED:
        return (ELSEWHERE, PART_ONLY)
    use = LOOK_THERE.format(model=EXTENDED)
    rest = (PART_ONLY,) if found.verdict is Verdict.PARTLY_EXPLAINED else ()
    worse = (WORSE,) if forecasts_are_worse(found) else ()
    if _is_sure(found):
        return (use, *worse, *rest)
    return (NOT_YET, *(advice or (MORE_DATA,)), *worse, *rest)


def forecasts_are_worse(found: Answer) -> bool:
    """Return whether recordings that were never fitted are forecast worse with what was found."""
    before, after = (found.scores[name]["measured"] for name in ("baseline", "extended"))
    return before is not None and after is not None and after > before


def _is_sure(found: Answer) -> bool:
    return all(_sure(finding) for finding in found.findings)


def _sure(finding: Finding) -> bool:
    return finding.probability >= SEARCH_CHOICE.sure_probability


def _words(count: int) -> str:
    small = ("No", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine", "Ten")
    return small[count] if count < len(small) else str(count)
