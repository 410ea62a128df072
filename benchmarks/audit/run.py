"""The audit's run: ranks, then fits one after the other, under progress bars, each kept as soon as it is done."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType

import numpy as np

from benchmarks.audit import by_modes, by_series
from benchmarks.audit.chain import Problem
from benchmarks.audit.nested import Target, sampled
from benchmarks.audit.ranks import PASSES, Uniform, uniform
from benchmarks.blind.rates import share
from benchmarks.certificate.code import code_of
from fe_models.files.atomic import write_json
from fe_models.progress import progress_bar

FIRST_SEED = 3_000_000  # of cases and of draws, which are of no other benchmark
AGREES = 1.0  # nats
SEARCHES: Mapping[str, ModuleType] = {"modes": by_modes, "series": by_series}
RANKED: Mapping[str, tuple[str, Callable[[Problem, int], dict[str, list[int]]]]] = {
    "by modes": ("modes", by_modes.ranked),
    "by modes, errors known": ("modes", by_modes.ranked_given_errors),
    "by series": ("series", by_series.ranked),
}
"""Whose posteriors are looked at, of which search."""


@dataclass(frozen=True)
class Size:
    """How much is done of each search: ``cases`` of ``claims`` fits each beside that of nothing wrong, ``draws`` of
    truths for ranks; ``live`` points of nested sampling.
    """

    cases: int
    claims: int
    draws: int
    live: int


WHOLE, QUICK = Size(5, 3, 200, 50), Size(1, 1, 10, 20)


@dataclass(frozen=True)
class Compared:
    """A fit of the ``search`` in the case of a ``seed``: what it ``claims`` with how many ``parameters``, its log
    evidence in ``closed`` form and by ``nested`` sampling, the ``error`` of that, its ``calls`` of the density, and the
    log ``odds`` of the claim beforehand.
    """

    search: str
    seed: int
    claims: str
    parameters: int
    closed: float
    nested: float
    error: float
    calls: int
    odds: float

    @property
    def delta(self) -> float:
        """By how much the closed form is above nested sampling, nats."""
        return self.closed - self.nested


def run_audit(size: Size, out: Path) -> None:
    """Collect ranks, compare evidences, and print both; what an earlier run of the same code and size kept is taken as
    it is.
    """
    code = code_of()
    numbers = f"{size.cases}_{size.claims}_{size.draws}_{size.live}"
    folder = out / "audit" / f"{code.commit[:12]}{code.changes[:12]}_{numbers}"
    ranks = {name: uniform(_ranks(name, size.draws, folder)) for name in RANKED}
    compared = _compared(size, folder)
    write_json(out / "audit.json", content(compared, ranks))
    print("\n".join([*evidence_table(compared), "", *rank_table(ranks, size.draws)]))
    print(f"Results: {out / 'audit.json'}")


def content(compared: Sequence[Compared], ranks: Mapping[str, Sequence[Uniform]]) -> dict[str, object]:
    """Return all for a JSON file."""
    evidences = [{**asdict(item), "delta": item.delta} for item in compared]
    return {
        "schema": 1,
        "evidences": evidences,
        "ranks": {name: [asdict(u) for u in own] for name, own in ranks.items()},
    }


def _ranks(name: str, draws: int, folder: Path) -> dict[str, list[list[int]]]:
    """Return the ranks (draw, parameter) by the kind of parameter."""
    path = folder / f"ranks_{name.replace(', ', '_').replace(' ', '_')}.json"
    if path.exists():
        known: dict[str, list[list[int]]] = json.loads(path.read_text(encoding="utf-8"))
        return known
    search, ranked = RANKED[name]
    problem, found = Problem.of(search), dict[str, list[list[int]]]()
    with progress_bar(f"Posteriors {name}", draws, "draw") as bar:
        for number in range(draws):
            for kind, own in ranked(problem, FIRST_SEED + number).items():
                found.setdefault(kind, []).append(own)
            bar.update()
    write_json(path, found)
    return found


def _compared(size: Size, folder: Path) -> list[Compared]:
    """Return all fits, of both searches in turn, those that are kept in the ``folder`` as they are."""
    fits, found = 1 + size.claims, list[Compared]()
    with progress_bar("Evidences", len(SEARCHES) * size.cases * fits, "fit") as bar:
        for seed in range(FIRST_SEED, FIRST_SEED + size.cases):
            for search in SEARCHES:
                path = folder / f"evidences_{search}_{seed}.json"
                known = [Compared(**item) for item in json.loads(path.read_text())] if path.exists() else []
                bar.update(len(known))
                targets = SEARCHES[search].case(Problem.of(search), seed, size.claims) if len(known) < fits else []
                for target in targets[len(known) :]:
                    known.append(_one(search, seed, target, size.live))
                    write_json(path, [asdict(item) for item in known])
                    bar.update()
                found += known
    return found


def _one(search: str, seed: int, target: Target, live: int) -> Compared:
    own = sampled(target, seed, live)
    numbers = len(target.mean), target.closed, own.evidence, own.error, own.calls, target.odds
    return Compared(search, seed, target.name, *numbers)


def evidence_table(compared: Sequence[Compared]) -> list[str]:
    """Return how far closed forms are from nested sampling, as a table in Markdown."""
    lines = ["| | by modes | by series | together |", "|---|---|---|---|"]
    groups = [[item for item in compared if item.search == search] for search in SEARCHES] + [list(compared)]
    columns = [_numbers(own) for own in groups]
    return lines + [f"| {what} | {' | '.join(own[what] for own in columns)} |" for what in columns[0]]


def _numbers(compared: Sequence[Compared]) -> dict[str, str]:
    deltas = np.array([item.delta for item in compared])
    close = share(bool(abs(delta) <= AGREES) for delta in deltas)
    low, high = close.interval
    cases = dict.fromkeys((item.search, item.seed) for item in compared)
    fits = [[item for item in compared if (item.search, item.seed) == case] for case in cases]
    return {
        "fits": str(len(compared)),
        "parameters": "-".join(str(of(item.parameters for item in compared)) for of in (min, max)),
        f"closed form within {AGREES:g} of log Z": f"{close}, {100 * low:.0f}-{100 * high:.0f} %",
        "same first cause, cases": str(share(_first(own, "closed") == _first(own, "nested") for own in fits)),
        "closed form less log Z, mean": f"{deltas.mean():+.2f}",
        "largest of these": f"{deltas[np.argmax(np.abs(deltas))]:+.2f}",
        "error of log Z, mean": f"{np.mean([item.error for item in compared]):.2f}",
    }


def _first(fits: Sequence[Compared], of: str) -> str:
    """Return what a case's most probable fit claims."""
    return max(fits, key=lambda item: float(getattr(item, of)) + item.odds).claims


def rank_table(ranks: Mapping[str, Sequence[Uniform]], draws: int) -> list[str]:
    """Return how even ranks are, as a table in Markdown."""
    lines = [f"| ranks of true values in {draws} posteriors | in ten bins | p | p > {PASSES:g} |", "|---|---|---|---|"]
    for name, every in ranks.items():
        for own in every:
            bins, passes = ", ".join(map(str, own.counts)), "yes" if own.p > PASSES else "no"
            lines.append(f"| {name}: {own.kind.replace('_', ' ')} | {bins} | {own.p:.2g} | {passes} |")
    return lines
