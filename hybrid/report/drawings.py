"""Drawings for a page: what other modules draw, as SVG within the page, in its colours."""

import re

from markupsafe import Markup

from fe_models.pictures.drawing import Picture
from fe_models.pictures.svg import svg_of
from hybrid.figures import Sheet
from hybrid.report.page import Figure

POINT = 96 / 72  # CSS pixels
MAX_WIDTH = 1020.0  # CSS pixels, of the page's text
GEOMETRY = re.compile(r'\b(?:d|x|y|width|height|transform)="[^"]*"')
DECIMALS = re.compile(r"(\.\d{2})\d+")
UNUSED = re.compile(r"<\?xml[^>]*>|<!DOCTYPE[^>]*>|<!--.*?-->|<metadata>.*?</metadata>", re.DOTALL)
ROOT = re.compile(r'<svg [^>]*?viewBox="([^"]*)"[^>]*>', re.DOTALL)
NAMES = re.compile(r'(\bid="|url\(#|href="#)')
COLOUR = re.compile(r"#([0-9a-fA-F]{6})\b")
STYLE = re.compile(r'style="[^"]*"')
SPACES = re.compile(r"\s*\n\s*")


def drawn(sheet: Sheet, name: str, caption: str, description: str) -> Figure:
    """Return what is drawn on a ``sheet``; ``name``: by which it is told from the others of a page."""
    text = sheet.svg()
    found = ROOT.search(text)
    if found is None:
        raise ValueError(f"{name}: no drawing with a viewBox")
    width = POINT * float(found[1].split()[2])
    body = text[found.end() :]
    svg = f'<svg viewBox="{found[1]}" aria-hidden="true">{body}'
    svg = UNUSED.sub("", svg).replace("xlink:href", "href")
    svg = GEOMETRY.sub(lambda part: DECIMALS.sub(r"\1", part[0]), SPACES.sub("\n", svg))
    svg = NAMES.sub(rf"\g<1>{name}-", svg).replace("/s^2", "/s²")
    return Figure(caption, description, Markup(in_colours_of_the_page(svg)), min(width, MAX_WIDTH))


def pictured(picture: Picture, caption: str, description: str) -> Figure:
    """Return a picture of a structure."""
    svg = Markup(in_colours_of_the_page(svg_of(picture)))
    return Figure(caption, description, svg, min(float(picture.width), MAX_WIDTH))


def in_colours_of_the_page(svg: str) -> str:
    """Return a drawing whose colours the page may set, by their own name: ``var(--c-555555, #555555)``."""

    def named(style: re.Match[str]) -> str:
        return COLOUR.sub(lambda found: f"var(--c-{found[1].lower()},#{found[1].lower()})", style[0])

    return STYLE.sub(named, svg)
