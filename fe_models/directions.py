"""Directions of dataset files: an axis, an angle in degrees from x towards y, or a vector of any length, [dx, dy], in
space also [dx, dy, dz].
"""

from fe_models.base_motion import unit_vector
from fe_models.errors import InputError
from fe_models.structure import ROTATIONS, TRANSLATIONS, Direction

FileDirection = Direction | float | tuple[float, ...]
ROUNDING = 1e-9  # of a component of length one


def components(direction: FileDirection) -> dict[Direction, float]:
    """Return the part of a direction along each axis that it has one along; `InputError` where it is none."""
    if isinstance(direction, str) and direction in (*TRANSLATIONS, *ROTATIONS):
        return {direction: 1.0}
    try:
        along = unit_vector(direction)
    except InputError:
        raise InputError(
            f"direction = {direction!r} is none; expected an axis, an angle in degrees from x towards y, or a vector"
            " [dx, dy], in space [dx, dy, dz]"
        ) from None
    return {axis: part for axis, part in zip(TRANSLATIONS, along, strict=False) if abs(part) > ROUNDING}


def axis_and_sign(direction: FileDirection) -> tuple[Direction, float]:
    """Return the axis that a sensor's direction is along, and -1 where it points the other way.

    `InputError` where it is along none.
    """
    parts = components(direction)
    if len(parts) > 1:
        raise InputError(
            f"direction = {direction!r} is between {' and '.join(parts)}, which sensors cannot be yet: of two sensors"
            " at the node, turn their channels to the axes, or turn the model"
        )
    ((axis, part),) = parts.items()
    return axis, 1.0 if part > 0 else -1.0
