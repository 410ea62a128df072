"""The few functions that force laws need, for floats, NumPy arrays, PyTorch tensors and Exudyn's symbolic numbers."""

import sys
from typing import Any

import numpy as np

SMOOTHING = 0.01
"""Half the width, relative to the way that leads to it, over which a contact sets in: see `smooth_ramp`."""
TINY = 1e-30  # keeps 0 / 0 from arising where there is no width; a normal number in single precision, too


def absolute(x: Any) -> Any:
    """Return the absolute value of ``x``."""
    return _apply("abs", x)


def sine(x: Any) -> Any:
    """Return the sine of ``x`` (rad)."""
    return _apply("sin", x)


def smooth_ramp(x: Any, width: Any) -> Any:
    """Return max(x, 0), within ``width`` of zero the parabola (x + width)^2 / (4 width) that joins it smoothly.

    Continuous with its first derivative; 0 below -width and x above it but for rounding; a plain ramp for width 0.
    """
    left, right = absolute(x + width), absolute(x - width)
    inside = 0.5 * (left - right) + width  # 0 to 2 width, as x runs from -width to width
    return inside * inside / (4 * width + TINY) + 0.5 * (x - width + right)


def _apply(name: str, x: Any) -> Any:
    """Call the function ``name`` of the library that ``x`` comes from; neither PyTorch nor Exudyn is imported here."""
    if hasattr(x, name):  # tensors have it as a method
        return getattr(x, name)()
    home = type(x).__module__
    library = sys.modules[home] if home.endswith("symbolic") else np
    return getattr(library, name)(x)
