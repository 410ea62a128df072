"""Which training goes with which model."""

from fe_models.arrays import FloatArray
from hybrid.config import TrainingConfig
from hybrid.estimation.experts import Experts, Hybrid
from hybrid.neural_modal_ode.driving import Driving
from hybrid.neural_modal_ode.state_prior import StatePrior
from hybrid.training.expert_training import ExpertsTrainer
from hybrid.training.gauss_newton import GaussNewtonTrainer
from hybrid.training.gradient_training import Trainer

AnyTrainer = Trainer | GaussNewtonTrainer | ExpertsTrainer


def trainer_for(
    model: Hybrid, windows: FloatArray, config: TrainingConfig, device: str = "cpu", driving: Driving | None = None
) -> AnyTrainer:
    """Return what trains ``model``: Gauss-Newton where states are solved for, gradients where they are encoded.

    ``driving``: what is known to drive the windows.
    """
    if isinstance(model, Experts):
        return ExpertsTrainer(model, windows, config, device)
    kind = GaussNewtonTrainer if isinstance(model.encoder, StatePrior) else Trainer
    return kind(model, windows, config, device, driving)
