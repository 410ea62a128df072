"""Which training goes with which model."""

from fe_models.dofs import FloatArray
from hybrid.config import TrainingConfig
from hybrid.gauss_newton import GaussNewtonTrainer
from hybrid.model import NeuralModalODE
from hybrid.state_estimation import StatePrior
from hybrid.training import Trainer


def trainer_for(
    model: NeuralModalODE, windows: FloatArray, config: TrainingConfig, device: str = "cpu"
) -> Trainer | GaussNewtonTrainer:
    """Return what trains ``model``: Gauss-Newton where states are solved for, gradients where they are encoded."""
    kind = GaussNewtonTrainer if isinstance(model.encoder, StatePrior) else Trainer
    return kind(model, windows, config, device)
