"""Experts: one Neural Modal ODE a training recording, weighed by how well each explains a window's first samples.

Recordings of one structure on different days are not quite of one structure: frequencies shift by a little, which a few
seconds turn into a large phase. One model of all recordings takes frequencies in between and is right about none; one
model for each stays sharp, and the first samples of a window show which recordings it resembles:

    x(t) = sum_e w_e(x_1..x_n) x_e(t),    w = softmax(log p_e(x_1..x_n) / n)

with the evidence log p_e of `StartEvidence`, n the number of samples: successive samples repeat each other, and count
as one. Modal coordinates are averaged like the channels, so that the mean is a motion in the same fixed mode shapes.
"""

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import replace
from typing import TypeVar, cast

import torch
from torch import Tensor, nn

from fe_models.errors import InputError
from hybrid.estimation.start_evidence import StartEvidence
from hybrid.neural_modal_ode.driving import Driving
from hybrid.neural_modal_ode.model import NeuralModalODE, Trajectory
from hybrid.neural_modal_ode.residuals.free_residual import NoResidual

NO_KNOWN_FORCES = (
    "experts are weighed by how free motions begin, and take no known loads or base motion: choose another --preset"
)


class Experts(nn.Module):
    """The weighted mean of ``members``, which have the same modes and sensors.

    ``counts`` (member,): how many of the training windows, one recording's after the other's, each member trains on.
    """

    def __init__(
        self, members: Sequence[NeuralModalODE], evidence: Sequence[StartEvidence], counts: Sequence[int]
    ) -> None:
        super().__init__()
        self._members = nn.ModuleList(members)
        self._evidence = nn.ModuleList(evidence)
        self.config = members[0].config
        self.measured = members[0].measured
        self.counts: Tensor
        self.register_buffer("counts", torch.tensor(counts))
        self.relative_error: Tensor
        self.register_buffer("relative_error", torch.zeros(()))  # of predictions, set when training is done

    @property
    def members(self) -> list[NeuralModalODE]:
        """The model of each recording."""
        return [cast(NeuralModalODE, member) for member in self._members]

    def without(self, member: int) -> "Experts":
        """Return the mean of the others, as if the recording of that member had not been there."""
        others = [i for i in range(len(self.members)) if i != member]
        evidence = [cast(StartEvidence, self._evidence[i]) for i in others]
        return Experts([self.members[i] for i in others], evidence, [int(self.counts[i]) for i in others])

    @property
    def channel_scale(self) -> Tensor:
        """What divides the channels (sensor,) that the first member sees."""
        return self.members[0].channel_scale

    def weights(self, windows: Tensor) -> Tensor:
        """Return each member's weight (batch, member) for windows (batch, time, sensor), of which the start is read."""
        start = windows[:, : self.config.encoder_samples, self.measured].flatten(1)  # (batch, time * channel)
        evidence = torch.stack([each(start) for each in self._evidence], dim=1)  # (batch, member)
        return torch.softmax(evidence / self.config.encoder_samples, dim=1)

    def initial_state(self, windows: Tensor) -> Tensor:
        """Return the weights, then every member's scaled z0, in one row (batch, member + member * 2 mode)."""
        return torch.cat([self.weights(windows), *(member.encode(windows)[0] for member in self.members)], dim=1)

    def scale_state(self, q: Tensor, q_dot: Tensor) -> Tensor:
        """Return what `initial_state` does for a user's own state, which no recording is more like than others."""
        weights = torch.full((len(q), len(self.members)), 1 / len(self.members), dtype=q.dtype, device=q.device)
        return torch.cat([weights, *(member.scale_state(q, q_dot) for member in self.members)], dim=1)

    def forecast(self, z0: Tensor, samples: int, driving: Driving | None = None) -> Trajectory:
        """Return the mean trajectory of ``samples`` samples from rows of `initial_state`; `InputError` under forces."""
        if driving is not None:
            raise InputError(NO_KNOWN_FORCES)
        members = self.members
        weights, states = z0[:, : len(members)], z0[:, len(members) :].chunk(len(members), dim=1)
        parts = [member.forecast(state, samples) for member, state in zip(members, states, strict=True)]

        def mean(name: str) -> Tensor:
            return torch.einsum("be,ebtc->btc", weights, torch.stack([getattr(part, name) for part in parts]))

        return Trajectory(mean("q"), mean("q_dot"), mean("q_ddot"), mean("channels"))


Hybrid = NeuralModalODE | Experts
"""What forecasts windows: one model of all training recordings, or one for each."""
Kind = TypeVar("Kind", bound=Hybrid)


def members_of(model: Hybrid) -> list[NeuralModalODE]:
    """Return the Neural Modal ODEs in ``model``."""
    return model.members if isinstance(model, Experts) else [model]


def fe_counterpart(model: Kind) -> Kind:
    """Return the model without anything learned in its dynamics: the FE model, exact in time, from the same start."""
    fe = deepcopy(model)
    for member in members_of(fe):
        member.config = replace(member.config, integrator="propagator")
        member.dynamics.residual = NoResidual(member.dynamics.modes).to(member.dynamics.a)
    return fe
