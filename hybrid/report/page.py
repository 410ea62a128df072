"""What a page shows, as plain data: sections of blocks, each of which a template of its own turns into HTML.

All texts are escaped there; a `Figure` alone holds markup, which this program has drawn.
"""

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

from markupsafe import Markup

from hybrid.report.motion import Motion


class Tone(Enum):
    """How good the news is, which a page shows by colour beside words."""

    GOOD = "good"
    FOUND = "found"
    OPEN = "open"
    BAD = "bad"


@dataclass(frozen=True)
class Heading:
    """A heading within a section."""

    template: ClassVar[str] = "heading"
    text: str


@dataclass(frozen=True)
class Paragraph:
    """A paragraph; a ``lead`` is larger, and what a reader in a hurry reads."""

    template: ClassVar[str] = "paragraph"
    text: str
    lead: bool = False


@dataclass(frozen=True)
class Bullets:
    """A list of sentences."""

    template: ClassVar[str] = "bullets"
    items: tuple[str, ...]


@dataclass(frozen=True)
class Cell:
    """A cell of a table; ``value``: the number by which its column is sorted, None of text; ``href``: where its text
    leads, relative to the page.
    """

    text: str
    value: float | None = None
    href: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of cells under ``columns``; the first cell of a row names it. ``note``: what is to be known of it."""

    template: ClassVar[str] = "table"
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    note: str = ""


@dataclass(frozen=True)
class Figure:
    """A drawing, ``svg``, with its ``caption``; ``description``: the same in words, for who does not see it.

    ``width``: in CSS pixels, as it was drawn.
    """

    template: ClassVar[str] = "figure"
    caption: str
    description: str
    svg: Markup
    width: float


@dataclass(frozen=True)
class MovingFigure:
    """Shapes that move: see `Motion`; ``description`` as of a `Figure`."""

    template: ClassVar[str] = "moving"
    caption: str
    description: str
    motion: Motion


Block = Heading | Paragraph | Bullets | Table | Figure | MovingFigure


@dataclass(frozen=True)
class Section:
    """A part of the page under its ``title``; ``name``: of its link."""

    name: str
    title: str
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Badge:
    """How far an answer may be trusted: a ``rate`` under a ``title``, its ``interval``, a ``sentence``, and a ``note``
    on where that is from.
    """

    title: str
    rate: str
    interval: str
    sentence: str
    note: str


@dataclass(frozen=True)
class Page:
    """A page: its ``title``; the answer, in a ``sentence`` under a ``verdict`` in a word or two, with a ``tone``;
    a ``summary`` of what that amounts to; ``facts`` beside it, each a name and a value; a ``badge``, where something is
    known of the like; what to do ``next``; then the ``sections``.
    """

    title: str
    verdict: str
    tone: Tone
    sentence: str
    summary: str
    facts: tuple[tuple[str, str], ...]
    next: tuple[str, ...]
    sections: tuple[Section, ...]
    footer: str
    badge: Badge | None = None
