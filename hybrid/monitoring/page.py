"""The page of a structure that is watched: whether it is as usual, since when it is not, and what changed."""

from collections.abc import Sequence
from datetime import datetime
from urllib.parse import quote

import numpy as np

from hybrid.monitoring.charts import draw_charts
from hybrid.monitoring.config import MONITORING
from hybrid.monitoring.observation import Kept, Observation, Standing, alarms_at_the_end
from hybrid.monitoring.tracked_modes import TrackedModes, tracked
from hybrid.monitoring.watching import PENDING
from hybrid.report.drawings import drawn
from hybrid.report.page import Block, Cell, Page, Paragraph, Section, Table, Tone
from hybrid.report.values import NOTHING, fixed, measured, percentage, typeset
from hybrid.report.values import sentence as sentence_of
from hybrid.result_sets import PAGE

MOST_SHOWN = 200  # recordings in charts and tables, the last ones: a page stays small enough to open
ACCEPT = (
    "If the change is known and meant to stay, after a repair say, give --accept: recordings since then begin a new"
    " history."
)
CHECK = "Check the sensors first: one that has come loose moves frequencies of some modes, or hides them."
CHART = (
    "Above: Hotelling's T² of the strongest frequencies together, over its control limit; beyond 1 they do not go"
    " together as usual. Below: each natural frequency with two standard deviations of its identification, and the"
    " limits within which the history says that it will lie."
)


def watch_page(kept: Kept, name: str, least_history: int) -> Page:
    """Return the page of what is kept of a structure, by its ``name``."""
    alarms = alarms_at_the_end(kept.observations)
    shown = [own for own in kept.observations if own.state == kept.state][-MOST_SHOWN:]
    modes = tracked(kept.history, MONITORING.min_seen, MONITORING.most_modes) if kept.history else None
    sections = [Section("charts", "Control charts", tuple(_charts(shown, modes)))]
    if modes is not None and len(modes.frequencies):
        sections.append(Section("modes", "The usual modes", (_modes(kept.history, modes),)))
    sections.append(Section("recordings", "All recordings", (_recordings(kept.observations[-MOST_SHOWN:]),)))
    verdict, tone, sentence = standing_of(kept, least_history)
    return Page(
        title=f"Watch of {name}",
        verdict=verdict,
        tone=tone,
        sentence=sentence,
        summary=sentence_of("; ".join(kept.observations[alarms[0]].words)) if alarms else "",
        facts=(("recordings", str(len(kept.observations))), ("in the history", str(len(kept.history)))),
        next=tuple(_next(kept.observations, alarms)),
        sections=tuple(sections),
        footer=f"Written {datetime.now():%d %B %Y, %H:%M}. This page loads nothing and reports to nobody.",
    )


def standing_of(kept: Kept, least_history: int) -> tuple[str, Tone, str]:
    """Return how the structure is: in a word or two, with a tone, and in a sentence."""
    alarms = alarms_at_the_end(kept.observations)
    history = len(kept.history)
    if alarms:
        since = kept.observations[alarms[0]].name
        many = "" if len(alarms) == 1 else f", and {len(alarms) - 1} more since"
        return "Alarm", Tone.BAD, f"The structure is not as it was, from recording {since} on{many}."
    if history < max(2, least_history):
        return (
            "Learning",
            Tone.OPEN,
            f"{history} of {max(2, least_history)} recordings that say what is usual are there.",
        )
    return "As usual", Tone.GOOD, f"The structure is as usual: {history} recordings make its history."


def _next(observations: Sequence[Observation], alarms: list[int]) -> list[str]:
    if not alarms:
        return []
    own = observations[alarms[0]]
    found = [f"Read {own.diagnosis}/{PAGE}: what changed, by a diagnosis of recordings before and after."]
    return [*(found if own.diagnosis and own.diagnosis != PENDING else []), CHECK, ACCEPT]


def _charts(shown: Sequence[Observation], modes: TrackedModes | None) -> list[Block]:
    seen = [own for own in shown if own.standing is not Standing.UNREADABLE]
    if modes is None or not seen:
        return [Paragraph("No recording could be read yet.")]
    names = ", ".join(own.name for own in seen if own.standing is Standing.ALARM) or "none"
    return [
        drawn(
            draw_charts(seen, modes),
            "charts",
            CHART,
            f"Charts of {len(modes.frequencies)} natural frequencies over {len(seen)} recordings; alarms: {names}.",
        )
    ]


def _modes(history: Sequence[Observation], modes: TrackedModes) -> Table:
    rows = list[tuple[Cell, ...]]()
    for mode in range(len(modes.frequencies)):
        own = [history[k].modes[n] for k, n in enumerate(modes.numbers[:, mode]) if n >= 0]
        values = np.array([(each.frequency, each.ratio, each.frequency_error) for each in own])
        scatter = float(values[:, 0].std(ddof=1)) if len(own) > 1 else 0.0
        rows.append(
            (
                Cell(f"{mode + 1}", float(mode + 1)),
                Cell(measured(float(values[:, 0].mean()), scatter, "Hz"), float(values[:, 0].mean())),
                Cell(f"{values[:, 2].mean():.2g} Hz", float(values[:, 2].mean())),
                Cell(percentage(float(values[:, 1].mean())), float(values[:, 1].mean())),
                Cell(f"{len(own)} of {len(history)}", float(len(own))),
            )
        )
    columns = ("mode", "mean and scatter", "deviation of one identification", "damping ratio", "seen in")
    return Table("Modes of the history, with standard deviations.", columns, tuple(rows))


def _recordings(observations: Sequence[Observation]) -> Table:
    rows = [_row(own) for own in reversed(observations)]
    columns = ("recording", "standing", "T² / limit", "what is unusual", "diagnosis")
    return Table("Recordings, the newest first.", columns, tuple(rows))


def _row(own: Observation) -> tuple[Cell, ...]:
    link = Cell(NOTHING)
    if own.diagnosis and own.diagnosis != PENDING:
        link = Cell("what changed", href=f"{quote(own.diagnosis)}/{PAGE}")
    words = typeset("; ".join(own.words)) or NOTHING
    return Cell(own.name), Cell(own.standing.value), fixed(own.distance, 2), Cell(words), link


def words_of(own: Observation) -> list[str]:
    """Return an observation in lines, for a terminal."""
    distance = "" if own.distance is None else f" (T^2 {own.distance:.2g} of its limit)"
    found = [f"{own.name}: {own.standing.value}{distance}", *(f"  {line}" for line in own.words)]
    return found + [f"  what changed: {own.diagnosis}/{PAGE}"] * (own.diagnosis not in ("", PENDING))
