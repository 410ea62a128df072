"""The structure with what was found built in: findings as effects, calibrated factors in its parts."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import Effect, ModalDamping
from fe_models.causes.modal_damping import replaced_ratios
from fe_models.damping import ratios_of_modes
from fe_models.structure import Carried, Structure
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.outcome.findings import Finding


def extended_structure(nominal: NominalModel, theta: FloatArray, findings: tuple[Finding, ...]) -> Structure:
    """Return the nominal structure, calibrated by ``theta`` (nuisance,), and the findings that are effects.

    Parts get their own factors, and elements what they are off by themselves. What the factors of the damping ratios
    change comes as modal ratios on top, negative ones where a mode is damped less: how dashpots couple the modes stays
    as it was, as in the search. A damping ratio that the dataset assumes stands in place of the structure's own
    damping, and is written into it.
    """
    factors, structure = np.exp(theta[: nominal.factors]), nominal.structure
    for part, factor in zip(nominal.parts, factors, strict=False):
        structure = part.scaled(structure, float(factor))
    structure = nominal.scatter.applied(structure, theta[nominal.factors : nominal.values])
    ratios = factors[len(nominal.parts) :]
    own, given = nominal.own_ratios - nominal.ratios, structure.damping.modal_ratios
    modal = own * (ratios - 1) + nominal.ratios * ratios
    settled = [mode - 1 for mode, _ in replaced_ratios(structure) if mode <= len(modal)]
    modal[settled] = ratios_of_modes(given, len(modal))[settled]  # an effect's ratio stands in its place
    if given or not nominal.ratios.any():
        rest = given[len(modal) :] or given[-1:] or (0.0,)
        modal = np.append(modal, rest)  # modes beyond those that are followed keep what they have
    damping = replace(structure.damping, modal_ratios=tuple(float(ratio) for ratio in modal))
    effects = tuple(_calibrated(effect, ratios) for effect in structure.effects)
    built = replace(structure, damping=damping, effects=effects)
    return built.with_effects(*(f.cause for f in findings if isinstance(f.cause, Effect)))


def _calibrated(effect: Carried, factors: FloatArray) -> Carried:
    """Return an effect of a structure, damping ratios that it sets times the ``factors`` (mode,) of these modes."""
    if not isinstance(effect, ModalDamping):
        return effect
    by_mode = dict(enumerate(factors, start=1))
    return replace(effect, ratio=tuple(float(ratio * by_mode.get(mode, 1.0)) for mode, ratio in effect.ratios))
