"""A modal model that is not that of the structure it stands for."""

from dataclasses import dataclass
from typing import ClassVar

from fe_models.causes.base import Cause


@dataclass(frozen=True)
class WrongModalModel(Cause):
    """A simulation with natural frequencies, damping ratios or shapes that its structure does not have.

    It has no parameters: the remedy is to take the structure's own modes, and how far off it is, mode by mode, is no
    single number.
    """

    kind: ClassVar[str] = "modal_model"
    template: ClassVar[str] = (
        "the modal model of the simulation is not that of its structure ({differs}): use the structure's own modes"
    )
