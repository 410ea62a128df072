"""How far a modal model is from the modes of its structure, in words."""

import numpy as np

from fe_models.arrays import TINY, FloatArray
from hybrid.diagnosis.nominal.config import MODAL_DIFFERENCE
from hybrid.diagnosis.nominal.modal_model import pairs
from hybrid.diagnosis.nominal.nominal_model import NominalModel


def difference(nominal: NominalModel, modal: NominalModel) -> str:
    """Return how far the modes of ``modal`` are from the ``nominal``'s own, each beside the one most like it."""
    (own_omega, own_shapes), (omega, shapes) = nominal.modes, modal.modes
    own, given, alike = pairs(own_shapes, shapes, nominal)
    frequency = omega[given] / own_omega[own] - 1
    ratios, own_ratios = modal.own_ratios[given], nominal.own_ratios[own]
    words = []
    if len(omega) != len(own_omega):
        words.append(f"{len(omega)} modes instead of {len(own_omega)}")
    if np.abs(frequency).max() > MODAL_DIFFERENCE.min_reported_difference:
        words.append(f"frequencies by {frequency.min():+.1%} to {frequency.max():+.1%}")
    if np.abs(ratios - own_ratios).max() > MODAL_DIFFERENCE.min_reported_difference:
        words.append(f"damping ratios {_range(ratios)} instead of {_range(own_ratios)}")
    if alike.min() < 1 - MODAL_DIFFERENCE.min_reported_difference:
        words.append(f"shapes with a MAC down to {alike.min():.3f}")
    if _coupling(nominal) > MODAL_DIFFERENCE.min_coupling_share:
        words.append("no damping between modes, which the structure's dashpots couple")
    return ", ".join(words) or "by little in each mode"


def _coupling(nominal: NominalModel) -> float:
    """Return the largest C_ij^2 / (C_ii C_jj) of two nominal modes, C_ii with all the damping that a mode has."""
    omega, shapes = nominal.modes
    C = shapes.T @ (nominal.damping @ shapes)
    whole = 2 * nominal.own_ratios[: len(omega)] * omega
    own = np.sqrt(np.maximum(whole, max(MODAL_DIFFERENCE.undamped_ratio_share * float(whole.max()), TINY)))
    return float(np.max(((C - np.diag(np.diag(C))) / own / own[:, None]) ** 2))


def _range(ratios: FloatArray) -> str:
    least, most = f"{ratios.min():.2%}", f"{ratios.max():.2%}"
    return least if least == most else f"{least} to {most}"
