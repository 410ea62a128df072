"""Directions of sensors and loads: an axis, an angle in degrees from x towards y, or a vector of any length,
[dx, dy], in space also [dx, dy, dz].
"""

from fe_models.base_motion import unit_vector
from fe_models.errors import InputError
from fe_models.structure import ROTATIONS, TRANSLATIONS, Direction

AnyDirection = Direction | float | tuple[float, ...]
ROUNDING = 1e-9  # of a component of length one


def components(direction: AnyDirection) -> dict[Direction, float]:
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


def axis_and_sign(direction: AnyDirection) -> tuple[AnyDirection, float]:
    """Return the axis that a direction is along, and -1 where it points the other way; between axes it stays.

    `InputError` where it is none.
    """
    parts = components(direction)
    if len(parts) > 1:
        return direction, 1.0
    ((axis, part),) = parts.items()
    return axis, 1.0 if part > 0 else -1.0


def direction_text(direction: AnyDirection) -> str:
    """Return a direction as one text: "x", "30" (degrees), "0.6,0.8"; see `direction_of_text`."""
    if isinstance(direction, tuple):
        return ",".join(f"{part:.9g}" for part in direction)
    return direction if isinstance(direction, str) else f"{direction:.9g}"


def direction_of_text(text: str) -> AnyDirection:
    """Return the direction that a text means; `InputError` where it means none."""
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        direction: object = text
    else:
        direction = numbers if len(numbers) > 1 else numbers[0]
    components(direction)  # type: ignore[arg-type]  # it is one, or there is an error
    return direction  # type: ignore[return-value]


def direction_words(direction: AnyDirection) -> str:
    """Return a direction for a sentence, after "in": "x", "(0.6, 0.8)"."""
    if isinstance(direction, str):
        return direction
    return f"({', '.join(f'{part:.3g}' for part in unit_vector(direction))})"
