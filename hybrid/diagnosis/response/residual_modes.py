"""Residual coordinates: how a frame gives way to force laws in the modes that are not followed.

One for each place where a law pulls: the static shape of those modes under that pull (residual attachment modes: Craig,
Structural Dynamics, 1981, ch. 19). Statically exact; a law that holds its place, as friction does, works against their
flexibility, and without it sticks and slips at other times.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh

from fe_models.arrays import FloatArray
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response.config import RESIDUAL


@dataclass(frozen=True)
class ResidualModes:
    """Oscillators of the nominal structure, at rest but for the forces of laws.

    ``omega`` (coordinate,), rad/s, ``ratio`` (coordinate,) of damping, ``shapes`` (dof, coordinate), mass-normalised
    where not slowed (see `residual_modes_of`), and ``pulled`` (coordinate, law), their part in each law's elongation.
    """

    omega: FloatArray
    ratio: FloatArray
    shapes: FloatArray
    pulled: FloatArray


def residual_modes_of(nominal: NominalModel, pulls: list[FloatArray]) -> ResidualModes | None:
    """Return the residual coordinates of laws with ``pulls`` (dof,) on the nominal model; None where it needs none.

    Those too fast for the recordings' sampling are slowed, by more mass, and as soft as before: what they add hardly
    moves then.
    """
    if nominal.kept is None or not pulls:
        return None
    every = np.stack(pulls, axis=1)  # (dof, law)
    bent, whole = np.stack([nominal.left_out(pull) for pull in pulls], axis=1), nominal.static(every)
    bent = bent[:, np.sum(every * bent, axis=0) > RESIDUAL.min_flexibility_share * np.sum(every * whole, axis=0)]
    if not bent.size:
        return None
    bent = bent / np.sqrt(np.sum(bent * (nominal.mass @ bent), axis=0))
    weight, turned = eigh(bent.T @ (nominal.mass @ bent))
    felt = weight > RESIDUAL.min_mass_share * weight[-1]
    white = turned[:, felt] / np.sqrt(weight[felt])
    square, own = eigh(white.T @ (bent.T @ (nominal.stiffness @ bent)) @ white)
    shapes, omega = bent @ (white @ own), np.sqrt(square)
    slowed = np.minimum(omega, 2 * np.pi * _fastest(nominal))
    shapes = shapes * (slowed / omega)
    ratio = np.einsum("dr,dr->r", shapes, nominal.damping @ shapes) / (2 * slowed) + nominal.ratios[-1]
    return ResidualModes(slowed, np.asarray(ratio), shapes, np.asarray(shapes.T @ every))


def _fastest(nominal: NominalModel) -> float:
    """Return the frequency (Hz) from which on a motion, once sampled, would look like one that the low-pass leaves."""
    clear = nominal.rate / 2 if nominal.lowpass is None else nominal.rate - nominal.lowpass.reach(RESIDUAL.folded_share)
    return max(clear, nominal.highest)
