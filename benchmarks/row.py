"""One line of the benchmark: a number, what it is held against, and where the other number comes from."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum


class Section(Enum):
    """A part of the benchmark's table."""

    CHAIN = "chain"
    LOADS = "loads"
    SAMPLED_FORCE = "sampled_force"
    AMBIENT_FRAME = "ambient_frame"
    SPEED = "speed"
    COST = "cost"
    ABLATIONS = "ablations"
    BRIDGE = "bridge"


@dataclass(frozen=True)
class Row:
    """``value`` of ``what`` in ``section``; ``peer`` says whose ``peer_value`` it is; ``aim``: what was to be reached.

    ``measured_peer``: the peer ran in the same run; otherwise its number is a published one.
    """

    section: str
    what: str
    value: float
    peer: str = ""
    peer_value: float | None = None
    measured_peer: bool = True
    aim: str = ""


def table(rows: Sequence[Row]) -> str:
    """Return the rows as a table in Markdown."""
    lines = ["| | | value | peer | peer's value | aim |", "|---|---|---|---|---|---|"]
    for row in rows:
        peer = row.peer + ("" if row.measured_peer or not row.peer else " (published)")
        other = "" if row.peer_value is None else f"{row.peer_value:.4g}"
        lines.append(f"| {row.section} | {row.what} | {row.value:.4g} | {peer} | {other} | {row.aim} |")
    return "\n".join(lines)
