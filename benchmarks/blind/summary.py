"""All that a run of blind cases found, as text and as JSON."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from benchmarks.blind.cases import BlindResult
from benchmarks.blind.confusion import confusion
from benchmarks.blind.confusion import text as confusion_text
from benchmarks.blind.rates import Rate, peer_names, rates, table
from benchmarks.blind.reliability import calibration
from benchmarks.blind.reliability import text as calibration_text
from benchmarks.blind_cases import BlindConfig


def text(results: Sequence[BlindResult], config: BlindConfig) -> str:
    """Return table, confusion matrix, calibration curve and every miss of cases like ``config``."""
    missed = [result.line for result in results if not result.judgement.first]
    return "\n\n".join(
        [
            table(_rates(results, config), peer_names(results)),
            confusion_text(confusion(results)),
            calibration_text(calibration(results)),
            "\n".join(["missed:", *missed]) if missed else "missed: none",
        ]
    )


def _rates(results: Sequence[BlindResult], config: BlindConfig) -> list[Rate]:
    return rates(results, config.tier, config.acts, config.excitation)


def content(results: Sequence[BlindResult], config: BlindConfig) -> dict[str, Any]:
    """Return the same for a JSON file, and every case."""
    names, matrix = peer_names(results), confusion(results)
    return {
        "schema": 1,
        "tier": config.tier,
        "acts": config.acts,
        "excitation": config.excitation,
        "rates": [rate.as_json(names) for rate in _rates(results, config)],
        "confusion": {"hidden": matrix.hidden, "named": matrix.named, "counts": matrix.counts.tolist()},
        "calibration": [item.as_json() for item in calibration(results)],
        "cases": [case_content(result) for result in results],
    }


def case_content(result: BlindResult) -> dict[str, Any]:
    """Return one case for a JSON file."""
    config = result.task.config
    return {
        "seed": result.task.seed,
        "hidden": result.task.hidden,
        "noise": config.noise,
        "size": config.size,
        **result.judgement.as_json(),
        "peers": {name: asdict(mark) for name, mark in result.peers.items()},
    }
