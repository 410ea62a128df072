"""The confusion matrix: which kinds were hidden, and which were named first."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.blind.cases import NOTHING, BlindResult
from fe_models.arrays import IntArray
from hybrid.diagnosis.outcome.verdict import Verdict

UNEXPLAINED = "unexplained"  # the word where something is wrong and nothing is named


@dataclass(frozen=True)
class Confusion:
    """``counts`` (hidden, named) of cases; ``right`` (hidden,): how many were answered right, the place, too."""

    hidden: tuple[str, ...]
    named: tuple[str, ...]
    counts: IntArray
    right: IntArray


def confusion(results: Sequence[BlindResult]) -> Confusion:
    """Return the matrix; kinds stand in the order in which they were hidden, the same in rows and columns."""
    hidden = tuple(dict.fromkeys(result.task.hidden for result in results))
    first = [named_first(result) for result in results]
    kinds = [word for word in hidden if word not in (NOTHING, UNEXPLAINED) and word in first]
    others = sorted(set(first) - set(kinds) - {NOTHING, UNEXPLAINED})
    columns = (*kinds, *others, NOTHING, UNEXPLAINED)
    counts = np.zeros((len(hidden), len(columns)), dtype=np.int64)
    right = np.zeros(len(hidden), dtype=np.int64)
    for result, name in zip(results, first, strict=True):
        row = hidden.index(result.task.hidden)
        counts[row, columns.index(name)] += 1
        right[row] += result.judgement.first
    return Confusion(hidden, columns, counts, right)


def named_first(result: BlindResult) -> str:
    """Return the kind that was named first, or a word for none."""
    if result.judgement.named:
        return result.judgement.named[0].split(" ")[0]
    return NOTHING if result.judgement.verdict is Verdict.NOTHING_WRONG else UNEXPLAINED


def text(matrix: Confusion) -> str:
    """Return the matrix as text, its columns numbered; "right": the whole answer, with the place."""
    width = max(len(word) for word in (*matrix.hidden, *matrix.named)) + 4
    lines = ["hidden".ljust(width) + "".join(f"{i + 1:4d}" for i in range(len(matrix.named))) + "  right"]
    for word, row, hits in zip(matrix.hidden, matrix.counts, matrix.right, strict=True):
        cells = "".join(f"{count:4d}" if count else "   ." for count in row)
        lines.append(word.ljust(width) + cells + f"  {hits}/{row.sum()}")
    legend = ", ".join(f"{i + 1} {word}" for i, word in enumerate(matrix.named))
    return "\n".join([*lines, f"named first: {legend}"])
