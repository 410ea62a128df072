"""A mode of a structure as somebody identified it from measurements, with what is known of its uncertainty."""

from dataclasses import dataclass
from typing import Literal

from fe_models.arrays import ComplexArray, FloatArray


@dataclass(frozen=True, repr=False)
class ModeEstimate:
    """A natural ``frequency`` (Hz) and what else was identified of a mode; None where it was not.

    ``recording`` names the state of the structure that it belongs to, and the recording of that name where there is
    one. ``shape`` (sensor,): displacements at the sensors' places and directions on any one scale, real or complex,
    whatever quantity the sensors record. Standard deviations: ``frequency_std`` in Hz; ``shape_std`` of each component,
    on the scale of the shape.
    """

    recording: str
    frequency: float
    frequency_std: float | None = None
    damping_ratio: float | None = None
    damping_std: float | None = None
    shape: FloatArray | ComplexArray | None = None
    shape_std: float | None = None
    role: Literal["train", "test"] = "train"

    def __repr__(self) -> str:
        spread = "" if self.frequency_std is None else f" +- {self.frequency_std:.2g}"
        damping = "" if self.damping_ratio is None else f", damping ratio {self.damping_ratio:.3g}"
        shape = "" if self.shape is None else f", shape at {len(self.shape)} sensors"
        return f"ModeEstimate({self.recording!r}: {self.frequency:.6g}{spread} Hz{damping}{shape}, {self.role})"
