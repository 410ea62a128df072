"""The Neural Modal ODE: encoder -> modal ODE with a learned rest -> fixed decoder (Lai et al. 2022, fig. 2)."""

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from fe_models.causes import ForceLaw
from fe_models.linear import ModalModel
from fe_models.recordings import Sensor
from hybrid.config import ModelConfig
from hybrid.neural_modal_ode.connectors import Connectors
from hybrid.neural_modal_ode.decoder import Decoder
from hybrid.neural_modal_ode.driving import Driving
from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.encoder import PaperEncoder, WindowEncoder
from hybrid.neural_modal_ode.integrators import integrate
from hybrid.neural_modal_ode.residuals import Residual
from hybrid.neural_modal_ode.residuals.backbone_residual import BackboneResidual
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual
from hybrid.neural_modal_ode.scaling import StateScale
from hybrid.neural_modal_ode.state_prior import StatePrior


@dataclass(frozen=True)
class Trajectory:
    """A forecast: modal coordinates and their two rates (batch, time, mode), and the channels (batch, time, sensor)."""

    q: Tensor
    q_dot: Tensor
    q_ddot: Tensor
    channels: Tensor


class NeuralModalODE(nn.Module):
    """The hybrid model of one structure and its sensors.

    ``sensors`` are all that are decoded; ``measured`` (their column numbers) are those that the encoder sees.
    ``channel_scale`` (sensor,) divides what the encoder sees; ``step`` (s) is the sampling interval. ``connectors`` are
    the places of a residual that is tied to the structure.
    """

    def __init__(
        self,
        config: ModelConfig,
        modal: ModalModel,
        effects: tuple[ForceLaw, ...],
        sensors: tuple[Sensor, ...],
        channel_scale: Tensor,
        state_scale: StateScale,
        step: float,
        connectors: Connectors | None = None,
    ) -> None:
        super().__init__()
        self.config = config
        self.step = step
        self.measured = [i for i, sensor in enumerate(sensors) if sensor.role == "measured"]
        self.channel_scale: Tensor
        self.register_buffer("channel_scale", channel_scale.to(torch.get_default_dtype()))  # (sensor,)
        self.relative_error: Tensor
        self.register_buffer("relative_error", torch.zeros(()))  # of predictions, set when training is done
        modes, channels = len(modal.omega), len(self.measured)
        self.encoder: PaperEncoder | WindowEncoder | StatePrior
        if config.encoder == "paper":
            self.encoder = PaperEncoder(channels, modes, config.encoder_hidden, config.rnn_hidden)
        elif config.encoder == "window":
            self.encoder = WindowEncoder(channels, modes, config.encoder_samples)
        else:
            self.encoder = StatePrior(torch.eye(2 * modes), torch.ones(channels))
        residual: Residual
        if connectors is not None:
            residual = ConnectorResidual(connectors, state_scale, config.net_hidden)
        elif config.residual == "backbone":
            residual = BackboneResidual(modes, config.net_hidden, config.zero_at_rest)
        else:
            residual = FreeResidual(modes, config.net_hidden, config.zero_at_rest)
        self.dynamics = ModalDynamics(modal, effects, state_scale, residual)
        self.substeps = max(config.substeps, self.dynamics.substeps(step))
        self.decoder = Decoder(modal, sensors)

    def encode(self, windows: Tensor, driving: Driving | None = None) -> tuple[Tensor, Tensor]:
        """Return mean and log-variance of the scaled z0, each (batch, 2 mode), from the start of windows.

        ``windows``: (batch, time, sensor) with at least `ModelConfig.encoder_samples` samples; all later ones and the
        held-out sensors are ignored. What the known forces of ``driving`` move from rest is taken away before, so that
        a free motion is encoded. `TypeError` of a model that has a `StatePrior` in its encoder's place: its states are
        solved for, by `estimation`.
        """
        if isinstance(self.encoder, StatePrior):
            raise TypeError("this model encodes no states: ask hybrid.estimation.forecast.posterior for them")
        first = windows[:, : self.config.encoder_samples]
        if driving is not None:
            rest = first.new_zeros(len(first), 2 * self.dynamics.modes)
            first = first - self.forecast(rest, first.shape[1], driving).channels
        mean, log_variance = self.encoder(first[:, :, self.measured] / self.channel_scale[self.measured])
        return mean, log_variance

    def forecast(self, z0: Tensor, samples: int, driving: Driving | None = None) -> Trajectory:
        """Return the trajectory of ``samples`` samples from scaled initial states z0 (batch, 2 mode).

        ``driving``: what is known to drive it, over at least as many samples.
        """
        config = self.config
        # (batch, time, 2 mode)
        z = integrate(self.dynamics, z0, samples, self.step, config.integrator, self.substeps, driving)
        force = self.dynamics.force(z)
        q, q_dot = self.dynamics.unscale(z)
        q_ddot = self.dynamics.acceleration(z, force)
        channels = self.decoder(q, q_dot, q_ddot)
        if driving is None:
            return Trajectory(q, q_dot, q_ddot, channels)
        known = driving.first(samples)
        return Trajectory(q, q_dot, q_ddot + known.acceleration, channels + known.shown)

    def decode(self, z: Tensor, force: Tensor) -> Tensor:
        """Return the channels (..., sensor) of scaled states (..., 2 mode) and the forces at them (..., mode)."""
        return self.decoder(*self.dynamics.unscale(z), self.dynamics.acceleration(z, force))

    def scale_state(self, q: Tensor, q_dot: Tensor) -> Tensor:
        """Return the scaled state (..., 2 mode) of modal coordinates and velocities that the user gives."""
        return torch.cat([q / self.dynamics.a, q_dot / self.dynamics.b], dim=-1)
