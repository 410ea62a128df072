"""Two forms of a linear rest: any stiffness and damping between modes, or springs and dashpots at places."""

import numpy as np
import torch
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.linear import ModalModel
from hybrid.estimation.config import LINEAR_CALIBRATION
from hybrid.neural_modal_ode.connectors import Connectors


class ModalParameters:
    """A rest (2, mode, mode) on top of the modal model, dimensionless.

    rest[0] scales as omega_i omega_j (stiffness), rest[1] as sqrt(omega_i omega_j) (damping).
    """

    is_exact = False  # modes that were left out, and shapes that are off, leave something in long windows in any case

    def __init__(self, modal: ModalModel) -> None:
        self.omega = torch.tensor(modal.omega, dtype=torch.float64)  # (mode,)
        self.ratio = torch.tensor(modal.damping_ratio, dtype=torch.float64)  # (mode,)

    def start(self) -> Tensor:
        """Return no rest: the modal model as it is."""
        modes = len(self.omega)
        return torch.zeros(2, modes, modes, dtype=torch.float64)

    def rates(self, rest: Tensor) -> tuple[Tensor, Tensor]:
        """Return d q'/dt as matrices on omega q and on q', each (mode, mode)."""
        root = self.omega.sqrt()
        stiffness = -torch.diag(self.omega) - self.omega[:, None] * rest[0]
        damping = -torch.diag(2 * self.ratio * self.omega) - root[:, None] * rest[1] * root[None, :]
        return stiffness, damping

    def penalty(self, rest: Tensor) -> Tensor:
        """Return what keeps the rest small where the sensors do not determine it, as a share of the windows' energy."""
        coupling = 1 - torch.eye(len(self.omega), dtype=torch.float64)
        return (
            LINEAR_CALIBRATION.coupling_penalty * (rest * coupling).square().sum()
            + LINEAR_CALIBRATION.diagonal_penalty * rest.square().sum()
        )


class ConnectorParameters:
    """Springs and dashpots (2, connector) in N/m and N s/m, which stand for the whole linear part.

    They start where their sum is nearest to the model: Lambda = sum k s s^T with s the rows of the connectors' shapes,
    by least squares; likewise the damping Phi^T C Phi (mode, mode): ``damping``, or the modal model's own diagonal.
    """

    is_exact = True  # what it leaves beyond the noise is not linear

    def __init__(self, modal: ModalModel, connectors: Connectors, damping: FloatArray | None = None) -> None:
        self.omega = torch.tensor(modal.omega, dtype=torch.float64)  # (mode,)
        self.shapes = torch.tensor(connectors.shapes, dtype=torch.float64)  # (connector, mode)
        self.feeds = torch.tensor(connectors.feeds, dtype=torch.float64)  # (connector, mode)
        products = np.einsum("cm,cn->mnc", connectors.shapes, connectors.shapes)  # (mode, mode, connector)
        diagonal = np.diag(2 * modal.damping_ratio * modal.omega)
        modal_matrices = [np.diag(modal.omega**2), diagonal if damping is None else damping]
        nearest = [
            np.linalg.lstsq(products.reshape(-1, len(self.shapes)), matrix.ravel(), rcond=None)[0]
            for matrix in modal_matrices
        ]
        self._start = torch.tensor(np.array(nearest))  # (2, connector)

    def start(self) -> Tensor:
        """Return the springs and dashpots nearest to the modal model."""
        return self._start.clone()

    def rates(self, rest: Tensor) -> tuple[Tensor, Tensor]:
        """Return d q'/dt as matrices on omega q and on q', each (mode, mode)."""
        stiffness = -(self.feeds.T * rest[0]) @ self.shapes / self.omega
        return stiffness, -(self.feeds.T * rest[1]) @ self.shapes

    def penalty(self, rest: Tensor) -> Tensor:
        """Return zero: as few numbers as there are places need no guard."""
        return rest.new_zeros(())
