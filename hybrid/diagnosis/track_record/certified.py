"""What the certificate counted, as it is installed with the program: a copy of what a badge needs of its numbers."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from fe_models.files.atomic import write_json

FILE = Path(__file__).with_name("certified.json")  # written by `hybrid-modal benchmark --certificate`
GROUPS = "groups' factors within two standard deviations"  # the certificate's name of that rate


@dataclass(frozen=True)
class Share:
    """``hits`` of ``count``, and the 95 % ``interval`` of the true rate (Wilson)."""

    hits: int
    count: int
    interval: tuple[float, float]


@dataclass(frozen=True)
class Bin:
    """How many of the causes named at a probability of ``low`` to ``high`` are ``right``."""

    low: float
    high: float
    right: Share


@dataclass(frozen=True)
class Column:
    """Cases of one kind, by its ``name``, ``done`` of the ``planned`` ones: of which ``structure``, how near the
    drawing is to the truth (``tier``), what moves it (``excitation``), and whether what is hidden ``acts`` in "all"
    recordings or in "one".

    ``named``: by the probability of a cause, how many are right; ``answers``: by the verdict, how many answers are;
    ``groups``: how many factors of groups that are off lie within two standard deviations.
    """

    name: str
    structure: str
    tier: str
    excitation: str
    acts: str
    planned: int
    done: int
    named: tuple[Bin, ...]
    answers: Mapping[str, Share]
    groups: Share


@dataclass(frozen=True)
class Certified:
    """The ``columns`` of the certificate of a ``commit``, with the SHA-256 of ``changes`` that are not committed, "" of
    none; on which ``days`` its cases ran.
    """

    commit: str
    changes: str
    days: tuple[str, ...]
    columns: tuple[Column, ...]


@cache
def certified() -> Certified:
    """Return what is installed."""
    return TypeAdapter(Certified).validate_json(FILE.read_bytes())


def installed_of(numbers: Mapping[str, Any]) -> Certified:
    """Return what is installed of the ``numbers`` of a ``certificate.json``."""
    columns = tuple(_column(own) for own in numbers["columns"])
    return Certified(numbers["commit"], numbers["changes"], tuple(numbers["days"]), columns)


def install(numbers: Mapping[str, Any], path: Path = FILE) -> Path:
    """Write what is installed of the ``numbers`` of a ``certificate.json``; return where."""
    write_json(path, TypeAdapter(Certified).dump_python(installed_of(numbers), mode="json"))
    return path


def _column(own: Mapping[str, Any]) -> Column:
    groups = next((_share(rate) for rate in own["rates"] if rate["what"] == GROUPS), Share(0, 0, (0.0, 1.0)))
    return Column(
        name=own["name"],
        structure=own["structure"],
        tier=own["tier"],
        excitation=own["excitation"],
        acts=own["acts"],
        planned=own["planned"],
        done=own["done"],
        named=tuple(Bin(item["low"], item["high"], _share(item["right"])) for item in own["calibration"]),
        answers={verdict: _share(item) for verdict, item in own.get("right_by_verdict", {}).items()},  # not of old ones
        groups=groups,
    )


def _share(item: Mapping[str, Any]) -> Share:
    low, high = item["interval"]
    return Share(item["hits"], item["count"], (low, high))
