"""A picture as SVG: patches as the outlines of their triangles, texts as texts; for pages, which restyle it."""

from collections.abc import Iterator
from html import escape

import numpy as np
from numpy.typing import NDArray

from fe_models.arrays import FloatArray
from fe_models.pictures.drawing import Color, Patch, Picture, Text

ANCHORS = {"left": "start", "center": "middle", "right": "end"}
BASELINE = 0.35  # of a text's height: how far below its middle its baseline lies


def svg_of(picture: Picture) -> str:
    """Return the picture as an element ``svg``, without a ground; colours as ``#rrggbb`` in ``style``."""
    shapes = "\n".join(
        f'<path style="fill:{_hex(color)}" d="{_path(loops, picture.height)}"/>'
        for patch in picture.patches
        for color, loops in _outlines(patch)
    )
    texts = "\n".join(_text(text, picture.height) for text in picture.texts)
    return f'<svg viewBox="0 0 {picture.width} {picture.height}" aria-hidden="true">\n{shapes}\n{texts}\n</svg>'


def _outlines(patch: Patch) -> Iterator[tuple[Color, list[FloatArray]]]:
    """Give the outlines, each (point, 2), of the triangles of each colour, which are all turned the same way."""
    shades = patch.colors[patch.triangles[:, 0]]
    for shade in np.unique(shades, axis=0):
        own = patch.triangles[(shades == shade).all(axis=1)]
        loops = [patch.points[loop] for loop in _loops(own)]
        red, green, blue = (int(channel) for channel in shade)
        yield (red, green, blue), [loop if _area(loop) > 0 else loop[::-1] for loop in loops]


def _loops(triangles: NDArray[np.int64]) -> list[list[int]]:
    """Return the closed lines about ``triangles`` (triangle, 3): edges that no two of them share."""
    begins, ends, count = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel(), int(triangles.max()) + 1
    edges = np.unique(begins * count + ends)
    outer = edges[~np.isin(edges, ends * count + begins)]
    after = dict[int, list[int]]()
    for a, b in zip((outer // count).tolist(), (outer % count).tolist(), strict=True):
        after.setdefault(a, []).append(b)
    loops = []
    for first, onwards in after.items():
        while onwards:
            loop, end = [first], onwards.pop()
            while end != first:
                loop.append(end)
                end = after[end].pop()
            loops.append(loop)
    return loops


def _area(loop: FloatArray) -> float:
    """Return twice the area that a closed line (point, 2) goes round, positive where it turns left."""
    (x, y), (end_x, end_y) = loop.T, loop[np.arange(1, len(loop) + 1) % len(loop)].T
    return float(x @ end_y - y @ end_x)


def _path(loops: list[FloatArray], height: int) -> str:
    return "".join("M" + "L".join(f"{x:.1f} {height - y:.1f}" for x, y in loop) + "Z" for loop in loops)


def _text(text: Text, height: int) -> str:
    y = height - text.y + BASELINE * text.size
    weight = ";font-weight:700" if text.bold else ""
    return (
        f'<text x="{text.x:.1f}" y="{y:.1f}" font-size="{text.size}" text-anchor="{ANCHORS[text.align]}"'
        f' style="fill:{_hex(text.color)}{weight}">{escape(text.text)}</text>'
    )


def _hex(color: Color) -> str:
    return "#{:02x}{:02x}{:02x}".format(*color)
