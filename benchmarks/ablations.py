"""What the parts of the hybrid model are for: each left out in turn, everything else the same.

The paper's two: a network beside the mode shapes in the decoder, and the physics term left out (appendix A). And a
third: the residual between modes, NN(z), against forces at places. All on a fifth of the paper's data, judged on the
channels of node 2, which no sensor ties down, and on those that were measured.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import torch
from torch import Tensor, nn

from benchmarks.row import Row
from fe_models.arrays import FloatArray
from fe_models.four_dof_data import paper_dataset
from fe_models.linear import ModalModel
from fe_models.progress import nothing
from fe_models.recordings import Dataset
from hybrid.config import Config, places_preset
from hybrid.estimation.forecast import forecast_windows
from hybrid.neural_modal_ode.decoder import Decoder
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.networks import mlp
from hybrid.training.preparation import prepare
from hybrid.training.scoring import nrmse
from hybrid.training.trainers import trainer_for

REALISATIONS = 200  # 160 to train on, 40 to test
EPOCHS = 20
CUBIC_STIFFNESS = 0.5  # N/m^3
HIDDEN = 64  # units a layer of the decoder's network


class NetDecoder(nn.Module):
    """x = E Phi [q, q', q''] + NN(q, q', q''): what the paper finds worse than mode shapes alone."""

    def __init__(self, decoder: Decoder) -> None:
        super().__init__()
        self.decoder = decoder
        sensors, modes = decoder.shapes.shape[1:]
        self.net = mlp(3 * modes, HIDDEN, sensors)

    def forward(self, q: Tensor, q_dot: Tensor, q_ddot: Tensor) -> Tensor:
        """Return the channels (..., sensor) from modal coordinates and their rates (..., mode)."""
        return self.decoder(q, q_dot, q_ddot) + self.net(torch.cat([q, q_dot, q_ddot], dim=-1))


def rows(
    modal: ModalModel, epochs: int = EPOCHS, realisations: int = REALISATIONS, advance: Callable[[], object] = nothing
) -> list[Row]:
    """Return the error at node 2 and of the measured channels of each variant; ``advance`` after each of five."""
    dataset = paper_dataset(CUBIC_STIFFNESS, modal, realisations=realisations, progress=False)
    plain = replace(Config().training, epochs=epochs)
    usual = Config(replace(Config().model, modes=4), plain)
    from_nothing = replace(usual, training=replace(plain, calibrate=False))
    scores = []
    for config, change in (
        (usual, unchanged),
        (usual, add_net_to_decoder),
        (from_nothing, unchanged),
        (from_nothing, leave_physics_out),
        (places_preset(), unchanged),
    ):
        scores.append(_score(dataset, config, change))
        advance()
    hybrid, with_net, uncalibrated, no_physics, places = scores
    found = []
    for what, value, peer, other in (
        ("Phi + NN as decoder", with_net, "Phi alone", hybrid),
        ("physics term left out, not calibrated", no_physics, "with it, not calibrated", uncalibrated),
        ("residual at places", places, "NN(z) between modes", hybrid),
    ):
        for name in ("node 2", "measured"):
            found.append(Row("ablation", f"{what}: NRMSE, {name}", value[name], peer, other[name]))
    return found


def unchanged(model: NeuralModalODE) -> None:
    """Leave the model as it is."""


def add_net_to_decoder(model: NeuralModalODE) -> None:
    """Put a network beside the mode shapes."""
    model.decoder = NetDecoder(model.decoder)  # type: ignore[assignment]


def leave_physics_out(model: NeuralModalODE) -> None:
    """Take Lambda and Gamma out of the latent ODE: all of it is left to be learned."""
    model.dynamics.physical.zero_()


def _score(dataset: Dataset, config: Config, change: Callable[[NeuralModalODE], None]) -> dict[str, float]:
    prepared = prepare(dataset, config)
    torch.manual_seed(config.training.seed)  # for what the change draws
    change(prepared.model)
    for _ in trainer_for(prepared.model, prepared.windows, config.training).epochs():
        pass
    windows = dataset.select("test")[0].data
    error = nrmse(forecast_windows(prepared.model, windows).channels, windows)  # (window, sensor)
    return {
        "node 2": _mean(error[:, [i for i, sensor in enumerate(dataset.sensors) if sensor.node == 2]]),
        "measured": _mean(error[:, prepared.model.measured]),
    }


def _mean(error: FloatArray) -> float:
    return float(np.nan_to_num(error, nan=np.inf).mean())
