"""A predicted motion of a whole structure as a notebook has it."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.errors import InputError
from fe_models.recordings import Sensor
from fe_models.structure import TRANSLATIONS


@dataclass(frozen=True, repr=False)
class PredictedField:
    """What `hybrid.predict` returns.

    Within 1.645 standard deviations the truth should lie nine times in ten; ``warnings`` say where in tests it did not.

    ``time`` (time,) in s; ``displacement`` and its standard deviation ``std`` (time, dof) in m and rad, at the rows of
    ``dofs``; ``channels`` and ``channels_std`` (time, sensor): what the sensors would show, without their noise. Of
    normalised channels displacements are relative.
    """

    time: FloatArray
    displacement: FloatArray
    std: FloatArray
    channels: FloatArray
    channels_std: FloatArray
    dofs: DofMap
    sensors: tuple[Sensor, ...]
    warnings: tuple[str, ...] = ()

    def at(self, node: int, direction: str) -> tuple[FloatArray, FloatArray]:
        """Return the displacement (time,) of a node in a direction, and its standard deviation.

        `InputError` where the model has no such degree of freedom.
        """
        try:
            row = self.dofs.row(node, direction)
        except KeyError as missing:
            raise InputError(str(missing.args[0])) from None
        return self.displacement[:, row], self.std[:, row]

    def __repr__(self) -> str:
        moved = np.abs(self.displacement) * np.isin(self.dofs.direction, TRANSLATIONS)
        instant, row = np.unravel_index(int(np.argmax(moved)), moved.shape)
        unit = "" if any(sensor.unit == "1" for sensor in self.sensors) else " m"
        place = f"node {self.dofs.node[row]} in {self.dofs.direction[row]}"
        value = f"{self.displacement[instant, row]:.3g} +- {self.std[instant, row]:.2g}{unit}"
        warned = "".join(f"\nWarning: {line}." for line in self.warnings)
        return (
            f"PredictedField({self.time[0]:.4g} to {self.time[-1]:.4g} s, {len(self.dofs)} degrees of freedom; largest"
            f" {value} at {place} at {self.time[instant]:.4g} s){warned}"
        )
