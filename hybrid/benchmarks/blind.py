"""Effects hidden in simulated recordings, diagnosed blind: how often kind, place and size come back."""

from collections.abc import Callable, Sequence
from dataclasses import replace

from fe_models.blind import BlindConfig, blind_case
from hybrid.calibration import nothing
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.judging import Judgement, judge

NOTHING = "nothing"  # the word for a clean case


def judged_cases(
    count: int,
    seed: int,
    kinds: Sequence[str],
    config: BlindConfig,
    advance: Callable[[], object] = nothing,
    miss: Callable[[str], object] = print,
) -> list[Judgement]:
    """Diagnose ``count`` cases with the seeds from ``seed`` on, the ``kinds`` in turn ("a+b" hides two at once).

    ``miss`` is given a line on every case that is not named right; ``advance`` is called after each case.
    """
    judgements = []
    for number in range(count):
        word = kinds[number % len(kinds)]
        hidden = () if word == NOTHING else tuple(word.split("+"))
        case = blind_case(seed + number, replace(config, kinds=hidden))
        judgements.append(judge(case, diagnose(case.dataset)))
        if not judgements[-1].first:
            miss(f"seed {seed + number}: {case.truth}{case.outside}: {judgements[-1].named}")
        advance()
    return judgements
