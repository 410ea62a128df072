"""How right a diagnosis is about a blind case, once the truth is opened."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import inf, isfinite
from typing import Any

from pydantic import TypeAdapter

from benchmarks.blind.groups import factors_within, is_far
from benchmarks.blind_cases import BlindCase
from fe_models.causes import Cause
from fe_models.recordings import TOLERANCE
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.diagnosis.outcome.verdict import Verdict

CONFIDENT_PROBABILITY = 0.9  # probability of a name: a wrong one is then a grave error
INTERVAL_SIGMA = 1.96  # standard deviations: half of an interval of 95 %
MAX_RELATIVE_ERROR = 0.1  # relative error of a parameter that counts as right
NUMERICS = ("regularisation", "phase", "side")  # what is no measure of the effect, or each recording's own


@dataclass(frozen=True)
class Judgement:
    """One case: what was hidden (``truth``) and what was ``named``, most important first, each "kind place".

    ``first``: whether the answer is right; ``listed``: whether the truth is named or among the alternatives;
    ``confidently_wrong``: whether a wrong name has a probability of 0.9 or more. ``probabilities`` of the findings,
    each with whether it is right. ``within`` and ``covered``: for each parameter of the right names whether it is close
    (10 % or two standard deviations), and within its interval of 95 %. ``groups``: for each group that is far from its
    drawing whether its factor is within two standard deviations of the true one. ``over_floor``: NRMSE of the extended
    model's forecast over the noise floor; processor ``seconds`` of the diagnosis.
    """

    truth: tuple[str, ...]
    named: tuple[str, ...]
    verdict: Verdict
    first: bool
    listed: bool
    confidently_wrong: bool
    probabilities: tuple[tuple[float, bool], ...]
    within: tuple[bool, ...]
    covered: tuple[bool, ...]
    groups: tuple[bool, ...]
    over_floor: float
    seconds: float

    def as_json(self) -> dict[str, Any]:
        """Return the fields for a JSON file, which has no infinity: None stands for it."""
        floor = self.over_floor if isfinite(self.over_floor) else None
        return asdict(self) | {"verdict": self.verdict.value, "over_floor": floor}

    @staticmethod
    def from_json(content: Mapping[str, Any]) -> "Judgement":
        """Return what `as_json` gave; a `ValidationError` of pydantic where it did not give it."""
        floor = content.get("over_floor")
        return TypeAdapter(Judgement).validate_python({**content, "over_floor": inf if floor is None else floor})

    @property
    def is_immaterial(self) -> bool:
        """Whether something was hidden that forecasts do not need, alone or beside what was named: what the report's
        rules ask not to be named.
        """
        if self.verdict is Verdict.NOTHING_WRONG:
            return bool(self.truth) and self.over_floor <= 1 + TOLERANCE
        beside = set(self.named) < set(self.truth)  # also of nothing beside groups that are off
        return beside and self.verdict is Verdict.EXPLAINED and self.over_floor <= 1 + VERDICT.min_second_gain


def key_of(cause: Cause) -> str:
    """Return kind and place of a cause as one word."""
    return f"{cause.kind} {cause.location}"


def judge(case: BlindCase, found: Answer) -> Judgement:
    """Return the judgement of a diagnosis: of the local causes that it names, and of groups that are as drawn.

    That a group is off where its structure is far from its drawing is said rightly, and is none of the hidden causes.
    """
    truth = tuple(key_of(cause) for cause in case.truth)
    findings = [item for item in found.findings if key_of(item.cause) in truth or not is_far(item.cause, case)]
    named = tuple(key_of(finding.cause) for finding in findings)
    listed = set(named)
    for finding in findings:
        listed |= {f"{item.kind} {item.location}" for item in finding.alternatives}
    right = [finding for finding in findings if key_of(finding.cause) in truth]
    wrong = [finding for finding in findings if key_of(finding.cause) not in truth]
    marks = [mark for finding in right for mark in _marks(finding, case)]
    if case.outside:
        first = found.verdict.is_wanting
    elif not truth:
        first = found.verdict is Verdict.NOTHING_WRONG
    elif len(truth) == 1:
        first = named[:1] == truth
    else:
        first = set(named) == set(truth)
    return Judgement(
        truth + case.outside,
        named,
        found.verdict,
        first,
        first or (bool(truth) and set(truth) <= listed),
        any(finding.probability >= CONFIDENT_PROBABILITY for finding in wrong),
        tuple((finding.probability, key_of(finding.cause) in truth) for finding in findings),
        tuple(within for within, _ in marks),
        tuple(covered for _, covered in marks),
        factors_within(found, case),
        _over_floor(found),
        found.seconds,
    )


def _over_floor(found: Answer) -> float:
    """Return the NRMSE of the extended model's forecast over the noise floor, infinity where there is no forecast."""
    error = found.scores["extended"]["measured"]
    return inf if error is None or not found.noise_floor else error / found.noise_floor


def no_report(hidden: str) -> Judgement:
    """Return what counts where a diagnosis ended without a report, whatever was ``hidden``: nothing is right."""
    return Judgement((hidden,), (), Verdict.UNEXPLAINED, False, False, False, (), (), (), (), inf, inf)


def _marks(finding: Finding, case: BlindCase) -> list[tuple[bool, bool]]:
    truth = next(cause for cause in case.truth if key_of(cause) == key_of(finding.cause))
    marks = []
    for word, value in truth.parameters.items():
        if word not in NUMERICS and isinstance(value, float) and finding.parameters[word].std > 0:
            item = finding.parameters[word]
            error = abs(item.value - value)
            limit = max(MAX_RELATIVE_ERROR * abs(value), 2 * item.std)
            marks.append((error <= limit, error <= INTERVAL_SIGMA * item.std))
    return marks
