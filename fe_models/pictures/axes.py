"""The directions of a drawing: x and y, in space also z."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.pictures import symbols
from fe_models.pictures.drawing import INK, Patch, Text
from fe_models.pictures.geometry import Outline
from fe_models.structure import TRANSLATIONS


def draw_axes(shape: Outline, at: FloatArray, patches: list[Patch], texts: list[Text]) -> None:
    """Add the directions x and y, in space also z, from ``at`` (2,) px."""
    if shape.in_space:
        at = at + np.array([42.0, 0.0])  # y leads to the left
    for direction in TRANSLATIONS if shape.in_space else TRANSLATIONS[:2]:
        way = shape.along(direction)
        patches.extend(symbols.arrow(at, at + 42 * way, INK, 2.0))
        x, y = (at + 54 * way).tolist()
        texts.append(Text(direction, x, y, 19, align="center"))
