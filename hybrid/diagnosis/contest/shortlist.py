"""Which causes go on: of those that were screened, and of those that have made their first steps."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import replace

from fe_models.causes.candidate import LawCandidate
from hybrid.diagnosis.contest.config import SHORTLIST
from hybrid.diagnosis.contest.effort import effort_of
from hybrid.diagnosis.contest.odds import Odds
from hybrid.diagnosis.fitting.least_squares import Step
from hybrid.diagnosis.screening.screening import Screened


def promising(ranked: list[list[Screened]], scanned: list[Screened], kept: int, odds: Odds) -> list[Screened]:
    """Return the best of each ranking and of a scan, not too many force laws among them.

    The best are so with their ``odds``; many places on a frame promise nearly the same, and then more of them go on.
    Each candidate once from where the first ranking that has it starts, once from the structure as drawn, and as it was
    ``scanned``, whose starts are far from the others' where the effect is large.
    """

    def behind(trial: Screened) -> float:
        return odds.price(trial.candidate) - trial.gain

    chosen: dict[tuple[str, bool, bool], Screened] = {}
    for ranking, far in (*((one, False) for one in ranked), (scanned, True)):
        taken, laws = 0, Counter[str]()
        nearer = SHORTLIST.by_modes_times if any(trial.is_drawn for trial in ranking) else 1
        most = kept * (SHORTLIST.scanned_times if far else nearer)
        tied = min(map(behind, ranking), default=0.0) + SHORTLIST.tied_fall * odds.alike
        for trial in sorted(ranking, key=behind):
            enough = taken >= (max(most, SHORTLIST.max_tied) if behind(trial) <= tied else most)
            hopeless = taken >= SHORTLIST.always_fitted and trial.gain < SHORTLIST.min_promised_fall
            if trial.gain <= 0 or enough or hopeless:
                continue
            if isinstance(trial.candidate, LawCandidate):
                full = laws.total() >= min(SHORTLIST.kept_laws, kept // 2)
                if full or laws[trial.candidate.kind] >= SHORTLIST.max_of_a_kind:
                    continue
                laws[trial.candidate.kind] += 1
            taken += 1
            leads = trial.is_drawn and taken <= SHORTLIST.leading
            chosen.setdefault((trial.candidate.key, trial.is_drawn, far), replace(trial, leads=leads))
        for trial in ranking:
            if not trial.candidate.names and trial.gain > 0:  # without a size to refine, its gain says little yet
                chosen.setdefault((trial.candidate.key, trial.is_drawn, far), trial)
    return list(chosen.values())


def not_too_many_of_a_kind(trials: list[Screened], most: int = SHORTLIST.max_of_a_kind) -> list[Screened]:
    """Return the first trials of each kind, at most so many."""
    numbers = _numbered(trial.candidate.kind for trial in trials)
    return [trial for trial, number in zip(trials, numbers, strict=True) if number <= most]


def most_promising_of_each_kind(trials: list[Screened]) -> list[Screened]:
    """Return those that promise most of each kind, what leads a ranking before all others."""
    ranked = sorted(trials, key=lambda trial: (not trial.leads, -trial.gain))
    return not_too_many_of_a_kind(ranked, SHORTLIST.max_first_of_a_kind)


def with_others(chosen: list[Screened], others: list[Screened]) -> list[Screened]:
    """Return the ``chosen`` trials and those ``others`` that would not begin where one of them does."""
    begun = {_begin(trial) for trial in chosen if trial.is_drawn}
    return chosen + [trial for trial in others if _begin(trial) not in begun]


def _begin(trial: Screened) -> tuple[str, int, tuple[float, ...]]:
    return trial.candidate.key, trial.candidate.brings, trial.start


def foremost(begun: list[tuple[Screened, Step]], odds: Odds) -> list[Step]:
    """Return the best of the first steps, of those as drawn and of others, not too many with a force law more.

    The best are so with their ``odds``, as in `promising`; what leads a ranking goes on in any case.
    """
    ranked = sorted(begun, key=lambda item: item[1].charged + odds.price(item[1].hypothesis.candidates[-1]))
    share = min(
        (effort_of(s.hypothesis.nominal).beside_law for _, s in begun if s.hypothesis.is_beside_law), default=1.0
    )
    laws = _first_of_each_kind([step for trial, step in ranked if isinstance(trial.candidate, LawCandidate)])[
        : SHORTLIST.kept_laws
    ]
    linear = [(trial, step) for trial, step in ranked if not isinstance(trial.candidate, LawCandidate)]
    others = [step for trial, step in linear if not trial.is_drawn][: int(share * SHORTLIST.foremost)]
    drawn = [(trial.leads, step) for trial, step in linear if trial.is_drawn]
    most = int(share * SHORTLIST.foremost_drawn)
    kept = [step for number, (leads, step) in enumerate(drawn) if leads or number < most]
    return sorted([*laws, *others, *kept], key=lambda step: step.charged)


def _first_of_each_kind(steps: list[Step]) -> list[Step]:
    """Return the first of each kind of force law, which may start far off, then the second, to the last."""
    numbers = _numbered(step.hypothesis.candidates[-1].kind for step in steps)
    kept = [(number, step) for number, step in zip(numbers, steps, strict=True) if number <= SHORTLIST.max_of_a_kind]
    return [step for _, step in sorted(kept, key=lambda item: item[0])]


def _numbered(kinds: Iterable[str]) -> list[int]:
    """Return of each kind in turn how often it has come, this time with it."""
    seen, found = Counter[str](), list[int]()
    for kind in kinds:
        seen[kind] += 1
        found.append(seen[kind])
    return found
