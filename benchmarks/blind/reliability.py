"""The calibration curve: of the findings named at a probability, how many are right."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from benchmarks.blind.cases import BlindResult
from benchmarks.blind.rates import Share

EDGES = (0.0, 0.5, 0.7, 0.9, 0.97, 1.0)  # of the bins: finer where decisions are made


@dataclass(frozen=True)
class Bin:
    """Findings named at ``low`` to ``high``: their mean probability (``promised``) and how many are ``right``."""

    low: float
    high: float
    promised: float
    right: Share

    def as_json(self) -> dict[str, Any]:
        """Return the bin for a JSON file."""
        return {"low": self.low, "high": self.high, "promised": self.promised, "right": self.right.as_json()}


def calibration(results: Sequence[BlindResult]) -> list[Bin]:
    """Return the bins that hold anything."""
    return bins_of([finding for result in results for finding in result.judgement.probabilities])


def bins_of(findings: Sequence[tuple[float, bool]]) -> list[Bin]:
    """Return the bins of findings, each its probability and whether it is right."""
    bins = []
    for low, high in pairwise(EDGES):
        own = [(p, right) for p, right in findings if low <= p < high or (p == high == EDGES[-1])]
        if own:
            promised = sum(p for p, _ in own) / len(own)
            bins.append(Bin(low, high, promised, Share(sum(right for _, right in own), len(own))))
    return bins


def text(bins: Sequence[Bin]) -> str:
    """Return the curve as text."""
    lines = ["named at     promised  right  95 % interval"]
    for item in bins:
        low, high = item.right.interval
        span = f"{item.low:.2f}-{item.high:.2f}"
        lines.append(f"{span:12s} {100 * item.promised:6.1f} %  {item.right}  {100 * low:.0f}-{100 * high:.0f} %")
    return "\n".join(lines)
