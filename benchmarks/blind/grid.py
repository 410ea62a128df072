"""How the rates fall: noise against size of the hidden effect, a few cases each."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from benchmarks.blind.cases import BlindResult, Task, tasks
from benchmarks.blind.rates import Share, share
from benchmarks.blind_cases import BlindConfig

NOISES = (0.01, 0.03, 0.1)  # of each channel's rms
SIZES = (0.0, 1 / 3, 2 / 3, 1.0)  # from barely detectable to large


@dataclass(frozen=True)
class Cell:
    """Cases of one ``noise`` and ``size``: right ``first``, ``listed``, ``wrong`` at 0.9 or more."""

    noise: float
    size: float
    first: Share
    listed: Share
    wrong: Share


def grid_tasks(count: int, seed: int, words: Sequence[str], config: BlindConfig) -> list[Task]:
    """Return ``count`` tasks for each noise and size; all have the same seeds, so that only these differ."""
    return [
        task
        for noise in NOISES
        for size in SIZES
        for task in tasks(count, seed, words, replace(config, noise=noise, size=size))
    ]


def cells(results: Sequence[BlindResult]) -> list[Cell]:
    """Return the rates of each noise and size."""
    found = []
    for noise, size in dict.fromkeys((r.task.config.noise, r.task.config.size) for r in results):
        own = [r.judgement for r in results if (r.task.config.noise, r.task.config.size) == (noise, size)]
        assert size is not None  # the grid sets it
        first, listed = share(item.first for item in own), share(item.listed for item in own)
        found.append(Cell(noise, size, first, listed, share(item.confidently_wrong for item in own)))
    return found


def table(found: Sequence[Cell]) -> str:
    """Return the cells as a table in Markdown."""
    lines = ["| noise | size | first | first or listed | wrong at >= 0.9 |", "|---|---|---|---|---|"]
    lines += [f"| {100 * c.noise:.0f} % | {c.size:.2f} | {c.first} | {c.listed} | {c.wrong} |" for c in found]
    return "\n".join(lines)
