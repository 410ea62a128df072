"""A model in space on a sheet of paper: seen from far above one side, z up (orthographic projection)."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.structure import TRANSLATIONS

AZIMUTH, ELEVATION = np.radians(28.0), np.radians(24.0)
"""Whence it is seen, from x towards y and above the horizon: so that few nodes of a regular frame hide others."""
SHEET: FloatArray = np.array(
    [
        [np.cos(AZIMUTH), -np.sin(AZIMUTH), 0.0],
        [np.sin(AZIMUTH) * np.sin(ELEVATION), np.cos(AZIMUTH) * np.sin(ELEVATION), np.cos(ELEVATION)],
    ]
)
"""What of x, y and z lies across and up on the sheet (2, 3): x to the right, y to the left and back."""

VIEW: FloatArray = np.vstack([SHEET, np.cross(SHEET[0], SHEET[1])])
"""The same, and what lies out of the sheet, towards the eye (3, 3)."""


def on_sheet(points: FloatArray) -> FloatArray:
    """Return points (..., 3), or vectors, on the sheet (..., 2)."""
    return np.asarray(points @ SHEET.T)


def in_view(points: FloatArray) -> FloatArray:
    """Return points (..., 3), or vectors, as across, up and out of the sheet (..., 3)."""
    return np.asarray(points @ VIEW.T)


def translations(dofs: DofMap, displacement: FloatArray, nodes: int) -> FloatArray:
    """Return ``displacement`` (dof,) as (node, 3): x, y, z, zero where a node has no such degree of freedom."""
    moved = np.zeros((nodes, len(TRANSLATIONS)))
    for column, direction in enumerate(TRANSLATIONS):
        rows = dofs.direction == direction
        moved[dofs.node[rows] - 1, column] = displacement[rows]
    return moved
