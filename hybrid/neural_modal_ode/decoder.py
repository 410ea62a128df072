"""The fixed decoder: mode shapes turn modal coordinates into displacements, velocities and accelerations."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor, nn

from fe_models.linear import ModalModel
from fe_models.recordings import Sensor, of_each_quantity
from fe_models.sensing import seen


def sensor_shapes(modal: ModalModel, sensors: Sequence[Sensor]) -> np.ndarray:
    """Return E Phi: the rows of the mode shapes that the sensors see, shape (sensor, mode)."""
    return seen(modal.dofs, sensors) @ modal.shapes


class Decoder(nn.Module):
    """x = E [Phi q, Phi q', Phi q'']: each sensor picks its row and its quantity. Nothing is learned here."""

    def __init__(self, modal: ModalModel, sensors: Sequence[Sensor]) -> None:
        super().__init__()
        shapes = torch.tensor(sensor_shapes(modal, sensors), dtype=torch.get_default_dtype())  # (sensor, mode)
        picks = torch.tensor(of_each_quantity(sensors))
        self.shapes: Tensor
        self.register_buffer("shapes", shapes[None] * picks[:, :, None])  # (quantity, sensor, mode)

    def forward(self, q: Tensor, q_dot: Tensor, q_ddot: Tensor) -> Tensor:
        """Return the channels (..., sensor) from modal coordinates and their two rates, each (..., mode)."""
        displacement, velocity, acceleration = self.shapes
        return q @ displacement.T + q_dot @ velocity.T + q_ddot @ acceleration.T
