"""Trials under a progress bar until so many cases were left open; what is at hand is written after each."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from benchmarks.blind.cases import CERTIFICATE_SEED
from benchmarks.blind.rates import Share, share
from benchmarks.next_measurement.trial import Trial, tried
from fe_models.errors import InputError
from fe_models.files.atomic import write_json
from fe_models.progress import progress_bar


def run_next(wanted: int, seed: int, out: Path) -> None:
    """Draw cases from ``seed`` on until ``wanted`` of them are open and something was advised; print the shares."""
    if seed >= CERTIFICATE_SEED:
        raise InputError(f"seed {seed}: those from {CERTIFICATE_SEED} on are for --certificate alone")
    found = list[Trial]()
    with progress_bar("Open cases", wanted, "case") as bar:
        while sum(trial.advised is not None for trial in found) < wanted:
            found.append(tried(seed + len(found)))
            bar.update(found[-1].advised is not None)
            write_json(out / "next.json", content(found))
    print(text(found))
    print(f"Results: {out}")


def shares(found: Sequence[Trial]) -> dict[str, Share]:
    """Return how many of the drawn cases are open, and how many of these each addition resolves."""
    left = [trial for trial in found if trial.advised is not None and trial.random is not None]
    return {
        "cases left open": share(trial.is_open for trial in found),
        "of these: nothing said to be of use": share(trial.advised is None for trial in found if trial.is_open),
        "resolved by what was advised": share(bool(trial.advised and trial.advised.resolves) for trial in left),
        "resolved by a random addition": share(bool(trial.random and trial.random.resolves) for trial in left),
        "named first with what was advised": share(bool(trial.advised and trial.advised.first) for trial in left),
        "named first with a random addition": share(bool(trial.random and trial.random.first) for trial in left),
    }


def content(found: Sequence[Trial]) -> dict[str, object]:
    """Return all for a JSON file."""
    return {
        "schema": 1,
        "shares": {name: own.as_json() for name, own in shares(found).items()},
        "trials": [asdict(trial) for trial in found],
    }


def text(found: Sequence[Trial]) -> str:
    """Return the shares, with Wilson's 95 % intervals, as a table in Markdown."""
    lines = ["| | share | 95 % interval |", "|---|---|---|"]
    for name, own in shares(found).items():
        low, high = own.interval
        lines.append(f"| {name} | {own} | {100 * low:.0f}-{100 * high:.0f} % |")
    return "\n".join(lines)
