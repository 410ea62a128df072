"""The structure with what was found built in: findings as effects, calibrated factors in its parts."""

from dataclasses import replace

import numpy as np

from fe_models.effects import Effect
from fe_models.structure import Dashpot, Structure
from hybrid.diagnosis.findings import Finding
from hybrid.diagnosis.plant import Plant


def extended_structure(plant: Plant, factors: tuple[float, ...], findings: tuple[Finding, ...]) -> Structure:
    """Return the nominal structure with calibrated ``factors`` (nuisance,) and the findings that are effects.

    Parts get their own factors. Damping ratios get theirs as modal ratios on top where they grow, and otherwise through
    the dashpots' least factor, since a structure's own modal ratios cannot be negative.
    """
    structure = plant.structure
    for part, factor in zip(plant.parts, factors, strict=False):
        structure = part.scaled(structure, factor)
    ratios = np.array(factors[len(plant.parts) :])
    dashpots: tuple[Dashpot, ...] = structure.dashpots
    damping = structure.damping
    own = plant.own_ratios - plant.ratios
    least = float(min(1.0, ratios.min()))
    if plant.damping.nnz:
        dashpots = tuple(replace(d, coefficient=d.coefficient * least) for d in dashpots)
        damping = replace(
            damping, mass_factor=damping.mass_factor * least, stiffness_factor=damping.stiffness_factor * least
        )
        kept = own * (ratios - least)
    else:
        kept = np.zeros_like(ratios)
    modal = tuple(float(ratio) for ratio in np.maximum(kept + plant.ratios * ratios, 0.0))
    if any(ratio > 0 for ratio in modal):
        damping = replace(damping, modal_ratios=modal)
    built = replace(structure, dashpots=dashpots, damping=damping)
    return built.with_effects(*(f.cause for f in findings if isinstance(f.cause, Effect)))
