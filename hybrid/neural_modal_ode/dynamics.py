"""The latent ODE q'' = -Lambda q - Gamma q' + known effects + learned rest (Lai et al. 2022, eq. 5)."""

import math
from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor, nn

from fe_models.arrays import FloatArray
from fe_models.causes import ForceLaw, MemorylessLaw
from fe_models.errors import raise_faults
from fe_models.linear import ModalModel
from hybrid.neural_modal_ode.config import DYNAMICS
from hybrid.neural_modal_ode.local_slopes import place_slopes
from hybrid.neural_modal_ode.residuals import Residual
from hybrid.neural_modal_ode.scaling import StateScale


def effect_shape(modal: ModalModel, law: ForceLaw) -> FloatArray:
    """Return b^T Phi (mode,): the elongation of an effect's force for a unit of each modal coordinate."""
    return np.asarray(modal.dofs.pull(law.pulls) @ modal.shapes)


class ModalDynamics(nn.Module):
    """Rate of the scaled state z = [q / a, q' / b] (scales a, b: one a mode, see `StateScale`).

    The physical part is fixed: Lambda = diag(omega^2), Gamma = diag(2 xi omega), and the force laws of
    the effects that the structure carries. The ``residual`` is what is learned. `InputError` for forces that depend on
    time, or on what the motion was before: a window does not say when in its recording it begins, nor what came before.
    """

    def __init__(self, modal: ModalModel, effects: Sequence[ForceLaw], scale: StateScale, residual: Residual) -> None:
        super().__init__()
        timed = dict.fromkeys(effect.kind for effect in effects if effect.timed)
        own = tuple(effect for effect in effects if isinstance(effect, MemorylessLaw))
        remembering = dict.fromkeys(effect.kind for effect in effects if not isinstance(effect, MemorylessLaw))
        raise_faults(
            [
                *(
                    f"the hybrid model takes no force that depends on time, and the structure has {kind}"
                    for kind in timed
                ),
                *(
                    f"the hybrid model takes no force with a memory, and the structure has {kind}: take it out of the"
                    " model, and a net learns what it can of it"
                    for kind in remembering
                ),
            ]
        )
        modes = len(modal.omega)
        self.modes = modes
        self.effects = own
        dtype = torch.get_default_dtype()
        shapes = np.array([effect_shape(modal, effect) for effect in effects]).reshape(len(effects), modes)
        self.a: Tensor
        self.b: Tensor
        self.physical: Tensor
        self.effect_shapes: Tensor
        self.register_buffer("a", torch.tensor(scale.displacement, dtype=dtype))  # (mode,)
        self.register_buffer("b", torch.tensor(scale.velocity, dtype=dtype))  # (mode,)
        self.register_buffer("effect_shapes", torch.tensor(shapes, dtype=dtype))  # (effect, mode)
        stiffness = np.diag(-(modal.omega**2) * scale.displacement / scale.velocity)
        damping = np.diag(-2 * modal.damping_ratio * modal.omega)
        self.register_buffer("physical", torch.tensor(np.hstack([stiffness, damping]), dtype=dtype))  # (mode, 2 mode)
        self.residual = residual

    def linear_part(self) -> Tensor:
        """Return A (2 mode, 2 mode) of z' = A z + [0, force(z)]: the fixed modal part and the learned linear rest."""
        upper = torch.cat([torch.zeros_like(self.physical[:, : self.modes]), torch.diag(self.b / self.a)], dim=1)
        return torch.cat([upper, self.physical + self.residual.linear(self.physical)], dim=0)

    def force(self, z: Tensor) -> Tensor:
        """Return what is not linear, (..., mode) in units of q'' / b: of the residual and the structure's effects."""
        force = self.residual(z)
        if self.effects:
            q, q_dot = self.unscale(z)
            force = force - self._effect_force(q, q_dot) / self.b
        return force

    def force_slopes(self, z: Tensor) -> Tensor:
        """Return d force / dz, (n, mode, 2 mode), at scaled states (n, 2 mode)."""
        slopes = self.residual.slopes(z)
        if self.effects:
            shapes = self.effect_shapes
            slopes = slopes - place_slopes(
                lambda u, v: self._effect_laws(u.T, v.T).T, shapes * self.a, shapes * self.b, shapes / self.b, z
            )
        return slopes

    def substeps(self, step: float) -> int:
        """Return into how many parts a ``step`` (s) must be split for the steepest of the structure's effects.

        The propagator takes forces explicitly: a stop in contact turns with sqrt(k |s|^2) rad/s, friction at rest
        decays with c |s|^2 1/s, s the effect's shape.
        """
        rates = [0.0]
        for effect, shape in zip(self.effects, self.effect_shapes.square().sum(dim=1).tolist(), strict=True):
            stiffness, damping = effect.largest_slopes
            rates += [math.sqrt(stiffness * shape), damping * shape]
        return max(1, math.ceil(step * max(rates) / DYNAMICS.max_phase_per_step))

    def _effect_force(self, q: Tensor, q_dot: Tensor) -> Tensor:
        return self._effect_laws(q @ self.effect_shapes.T, q_dot @ self.effect_shapes.T) @ self.effect_shapes

    def _effect_laws(self, u: Tensor, v: Tensor) -> Tensor:
        """Return each effect's force at its elongation and rate, (..., effect) all."""
        return torch.stack([effect.force(u[..., i], v[..., i]) for i, effect in enumerate(self.effects)], dim=-1)

    def unscale(self, z: Tensor) -> tuple[Tensor, Tensor]:
        """Return q and q' (..., mode) of scaled states (..., 2 mode)."""
        q, q_dot = z.chunk(2, dim=-1)
        return q * self.a, q_dot * self.b

    def acceleration(self, z: Tensor, force: Tensor) -> Tensor:
        """Return q'' (..., mode) of scaled states (..., 2 mode), given `force` at them."""
        return (z @ self.linear_part()[self.modes :].T + force) * self.b

    def forward(self, t: Tensor, z: Tensor) -> Tensor:
        """Return dz/dt (..., 2 mode), in the form that `torchdiffeq` asks for."""
        rate = z @ self.linear_part().T
        return torch.cat([rate[..., : self.modes], rate[..., self.modes :] + self.force(z)], dim=-1)
