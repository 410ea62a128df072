"""What a figure is made of: shapes in panels, what all panels share, and where a panel lies on the picture."""

from dataclasses import dataclass

from fe_models.arrays import FloatArray, IntArray
from fe_models.pictures.drawing import Color
from fe_models.pictures.geometry import Outline
from fe_models.recordings import Sensor

MARGIN = 40  # px, free on all sides


@dataclass(frozen=True)
class Shape:
    """One ``displacement`` (dof,) to draw: coloured by magnitude, or in one ``color``; ``width`` times as thick."""

    displacement: FloatArray
    color: Color | None = None
    width: float = 1.0


@dataclass(frozen=True)
class Panel:
    """Shapes drawn over each other, the first at the bottom, with a label."""

    label: str
    shapes: tuple[Shape, ...]


@dataclass(frozen=True)
class Sweep:
    """What moves beside the names of sensors, in m: their nodes, ``sensors`` (frame, sensor, 2), in all pictures, and
    points of the ``lines`` (seen, point, 2) in those of the pictures that are looked at, ``frames`` (seen,).
    """

    sensors: FloatArray
    lines: FloatArray
    frames: IntArray


@dataclass(frozen=True)
class Figure:
    """What all panels share: exaggeration ``scale``, colours up to ``largest``, corners ``reach`` (2, 2) of all, in m.

    ``unit`` is "m" or "1" (relative); ``sweep``: where ``sensors`` move; ``named``: name, colour and width (px) of
    each shape in a comparison, which has no colour bar.
    """

    outline: Outline
    scale: float
    largest: float
    reach: FloatArray
    title: str
    note: str
    unit: str = "m"
    sensors: tuple[Sensor, ...] = ()
    sweep: Sweep | None = None
    named: tuple[tuple[str, Color, float], ...] = ()
    width: int = 1600


@dataclass(frozen=True)
class View:
    """Where a panel lies: pixel = ``corner`` + ``factor`` (point - ``low``); ``sign`` is the size of symbols (px)."""

    low: FloatArray
    corner: FloatArray
    factor: float
    sign: float
    weight: float

    def __call__(self, points: FloatArray) -> FloatArray:
        """Return points (..., 2) in m as pixels."""
        return self.corner + self.factor * (points - self.low)
