"""What the certificate counts: the numbers of each column, and of all together."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks.blind.cases import BlindResult, Task
from benchmarks.blind.rates import Rate, Share, rates, share
from benchmarks.blind.reliability import Bin, bins_of, calibration
from benchmarks.certificate.code import Code
from benchmarks.certificate.plan import Column
from benchmarks.certificate.record import Record

PERCENTILE = 99  # per cent of the cases take less time than the slow end that is stated
LIMITS = {"four_dof": 30.0, "bridge": 180.0}  # s: what a case may take


@dataclass(frozen=True)
class Seconds:
    """Processor times of reports, s: ``median``, 99th ``percentile``, ``longest``; ``aim`` of the longest."""

    median: float
    percentile: float
    longest: float
    aim: float


@dataclass(frozen=True)
class ColumnCounts:
    """The numbers of a ``column``, of which ``done`` cases are there.

    ``hidden``: by what was hidden how many answers are right, of those cases that forecasts need. ``findings``: by the
    kind that was named, the curve of calibration. ``verdicts``: how many reports end so; ``unnamed``: of those that
    name nothing, how many are right to. ``failures``: by the name of the failure, cases without a report.
    """

    column: Column
    done: int
    rates: tuple[Rate, ...]
    calibration: tuple[Bin, ...]
    hidden: Mapping[str, Share]
    findings: Mapping[str, tuple[Bin, ...]]
    verdicts: Mapping[str, int]
    unnamed: Mapping[str, Share]
    failures: Mapping[str, int]
    seconds: Seconds | None


@dataclass(frozen=True)
class Certificate:
    """All that is printed: of what ``code``, on which ``machines`` and ``days``, and the numbers."""

    code: Code
    columns: tuple[ColumnCounts, ...]
    calibration: tuple[Bin, ...]
    machines: tuple[str, ...]
    days: tuple[str, ...]

    @property
    def done(self) -> int:
        """The number of cases that are there."""
        return sum(own.done for own in self.columns)

    @property
    def planned(self) -> int:
        """The number of cases of a whole certificate."""
        return sum(own.column.count for own in self.columns)


def certificate(code: Code, columns: Sequence[Column], records: Mapping[Task, Record]) -> Certificate:
    """Return the numbers of all ``records`` that are there."""
    return Certificate(
        code,
        tuple(counts(column, records) for column in columns),
        tuple(calibration([record.result(task) for task, record in records.items()])),
        tuple(sorted({record.machine for record in records.values()})),
        tuple(sorted({record.day for record in records.values()})),
    )


def counts(column: Column, records: Mapping[Task, Record]) -> ColumnCounts:
    """Return the numbers of a column."""
    own = [(task, records[task]) for task in column.tasks if task in records]
    results = [record.result(task) for task, record in own]
    reports = [record.judgement for _, record in own if record.judgement]
    failures = Counter(record.failure for _, record in own if record.judgement is None)
    none = Rate("no report, which counts as wrong above", Share(failures.total(), len(own)), "0")
    every = rates(results, column.tier, column.acts, column.excitation, empty=True) if results else []
    shares = [rate for rate in every if isinstance(rate.measured, Share)]
    return ColumnCounts(
        column,
        len(own),
        (*shares, none) if own else (),
        tuple(calibration(results)),
        {word: _right(results, word) for word in dict.fromkeys(column.words)},
        _findings(results),
        dict(Counter(report.verdict.value for report in reports)),
        _unnamed([record.result(task) for task, record in own if record.judgement]),
        dict(failures),
        _seconds([report.seconds for report in reports], LIMITS[column.structure]),
    )


def _right(results: Sequence[BlindResult], word: str) -> Share:
    return share(r.judgement.first for r in results if r.task.hidden == word and not r.is_immaterial)


def _unnamed(results: Sequence[BlindResult]) -> dict[str, Share]:
    """Return how many reports that name nothing end so, and are right to: of causes too weak to matter, too."""
    marks: dict[str, list[bool]] = {}
    for result in results:
        if not result.judgement.named:
            right = result.judgement.first or result.is_immaterial
            marks.setdefault(result.judgement.verdict.value, []).append(right)
    return {verdict: share(own) for verdict, own in marks.items()}


def _findings(results: Sequence[BlindResult]) -> dict[str, tuple[Bin, ...]]:
    """Return the curve of calibration by the kind that was named."""
    found: dict[str, list[tuple[float, bool]]] = {}
    for result in results:
        for name, mark in zip(result.judgement.named, result.judgement.probabilities, strict=True):
            found.setdefault(name.split(" ")[0], []).append(mark)
    return {kind: tuple(bins_of(marks)) for kind, marks in sorted(found.items())}


def _seconds(times: Sequence[float], aim: float) -> Seconds | None:
    if not times:
        return None
    return Seconds(float(np.median(times)), float(np.percentile(times, PERCENTILE)), max(times), aim)


def content(found: Certificate) -> dict[str, Any]:
    """Return the numbers for a JSON file; neither seeds nor single cases are in it."""
    return {
        "schema": 1,
        **asdict(found.code),
        "machines": found.machines,
        "days": found.days,
        "planned": found.planned,
        "done": found.done,
        "columns": [_column_content(own) for own in found.columns],
        "calibration": [item.as_json() for item in found.calibration],
    }


def _column_content(own: ColumnCounts) -> dict[str, Any]:
    return {
        "name": own.column.name,
        "structure": own.column.structure,
        "tier": own.column.tier,
        "excitation": own.column.excitation,
        "acts": own.column.acts,
        "planned": own.column.count,
        "done": own.done,
        "rates": [rate.as_json(()) for rate in own.rates],
        "calibration": [item.as_json() for item in own.calibration],
        "right_by_hidden": {word: right.as_json() for word, right in own.hidden.items()},
        "calibration_by_named": {kind: [item.as_json() for item in bins] for kind, bins in own.findings.items()},
        "verdicts": own.verdicts,
        "right_by_verdict": {verdict: right.as_json() for verdict, right in own.unnamed.items()},
        "failures": own.failures,
        "seconds": None if own.seconds is None else asdict(own.seconds),
    }
