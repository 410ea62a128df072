"""The words and numbers on pictures: exaggeration, pace, units that read well."""


def readable(largest: float, unit: str) -> tuple[float, str]:
    """Return the factor and name of the unit in which ``largest`` (m, or relative where ``unit`` is "1") reads well."""
    if unit != "m":
        return 1.0, "relative"
    if largest >= 0.5:
        return 1.0, "m"
    return (1e6, "µm") if 0 < largest < 5e-4 else (1e3, "mm")


def digits(value: float, count: int) -> str:
    """Return ``value`` with ``count`` significant digits, trailing zeros included."""
    return f"{value:#.{count}g}".rstrip(".")


def exaggeration(scale: float, largest: float, unit: str) -> str:
    """Return how much larger displacements are drawn than they are; ``largest`` in m, or relative."""
    if unit != "m":
        return f"relative displacements; the largest, {largest:.3g}, is drawn as {scale * largest:.2g} m"
    if scale == 1:
        return "displacements drawn to the scale of the structure"
    return f"displacements drawn {scale:,.6g} times as large"


def pace(frames: int, fps: float, duration: float) -> str:
    """Return how fast a film runs that shows ``duration`` s of motion in ``frames`` pictures, ``fps`` a second."""
    slowness = (frames - 1) / fps / duration if duration > 0 else 1.0
    if abs(slowness - 1) < 0.05:
        return "shown in real time"
    return f"shown {slowness:.2g} times slower" if slowness > 1 else f"shown {1 / slowness:.2g} times faster"
