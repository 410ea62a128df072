"""A page as HTML: one file that needs no other, and asks for none."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from hybrid.report.page import Block, Figure, MovingFigure, Page, Section, Table

TEMPLATES = Path(__file__).parent / "templates"
PROGRAMS = ("page.js", "zoom.js")
MAX_BYTES = 10_000_000  # of a page: what mail takes
TOO_LARGE = (
    "Some of the page was left out, so that it stays small enough for mail: {captions}. The picture files beside it"
    " have more."
)
NUMBERED = {Table: "Table", Figure: "Figure", MovingFigure: "Figure"}


@cache
def _environment() -> Environment:
    return Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def rendered(page: Page) -> str:
    """Return the page as HTML, below `MAX_BYTES`: the largest figures are left out where it would be larger."""
    left_out = list[str]()
    while True:
        html = _rendered(page, left_out)
        if len(html.encode()) <= MAX_BYTES:
            return html
        largest = max(_figures(page), key=lambda figure: len(figure.svg), default=None)
        if largest is None:
            raise ValueError(f"a page of {len(html)} characters has no figure to leave out")
        left_out.append(largest.caption.rstrip("."))
        page = _without(page, largest)


def _rendered(page: Page, left_out: Iterable[str]) -> str:
    numbers = _numbers(page)
    missing = TOO_LARGE.format(captions="; ".join(left_out)) if left_out else ""
    template = _environment().get_template("page.html")
    return template.render(
        page=page,
        number=lambda block: numbers[id(block)],
        missing=missing,
        style=Markup((TEMPLATES / "style.css").read_text(encoding="utf-8")),
        script=Markup("\n".join((TEMPLATES / name).read_text(encoding="utf-8") for name in PROGRAMS)),
    )


def _figures(page: Page) -> list[Figure]:
    return [block for section in page.sections for block in section.blocks if isinstance(block, Figure)]


def _without(page: Page, left_out: Block) -> Page:
    sections = (
        Section(own.name, own.title, tuple(block for block in own.blocks if block is not left_out))
        for own in page.sections
    )
    return replace(page, sections=tuple(sections))


def _numbers(page: Page) -> dict[int, str]:
    """Return how each table and figure is called, by its identity: "Table 2"."""
    found, counts = dict[int, str](), dict[str, int]()
    for section in page.sections:
        for block in section.blocks:
            word = NUMBERED.get(type(block))
            if word is not None:
                counts[word] = counts.get(word, 0) + 1
                found[id(block)] = f"{word} {counts[word]}"
    return found
