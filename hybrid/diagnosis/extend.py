"""The structure with what was found built in: findings as effects, calibrated factors in its springs and masses."""

from dataclasses import replace

import numpy as np

from fe_models.effects import Effect
from fe_models.structure import Dashpot, Spring, Structure
from hybrid.diagnosis.findings import Finding
from hybrid.diagnosis.plant import Plant


def extended_structure(plant: Plant, factors: tuple[float, ...], findings: tuple[Finding, ...]) -> Structure:
    """Return the nominal structure with calibrated ``factors`` (nuisance,) and the findings that are effects.

    Springs and masses get their own factors. Damping ratios get theirs as modal ratios on top where they grow, and
    otherwise through the dashpots' mean factor, since a structure's own modal ratios cannot be negative.
    """
    structure = plant.structure
    n = plant.size
    springs = factors[: len(plant.springs)]
    masses = factors[len(plant.springs) : len(plant.springs) + n]
    ratios = np.array(factors[len(plant.springs) + n :])
    elements = tuple(
        replace(element, stiffness=element.stiffness * springs[i]) if isinstance(element, Spring) else element
        for i, element in enumerate(structure.elements)
    )
    by_node = {int(plant.dofs.node[row]): masses[i] for i, row in enumerate(plant.dofs.free_rows)}
    points = tuple(replace(m, mass=m.mass * by_node.get(m.node, 1.0)) for m in structure.point_masses)
    dashpots: tuple[Dashpot, ...] = structure.dashpots
    damping = structure.damping
    omega2, shapes = np.linalg.eigh(_normalised(plant))
    omega = np.sqrt(np.maximum(omega2, 1e-300))
    root = np.linalg.inv(np.linalg.cholesky(plant.mass)).T @ shapes
    own = np.einsum("di,de,ei->i", root, plant.damping, root) / (2 * omega)
    least = float(min(1.0, ratios.min()))
    if plant.damping.any():
        dashpots = tuple(replace(d, coefficient=d.coefficient * least) for d in dashpots)
        damping = replace(
            damping, mass_factor=damping.mass_factor * least, stiffness_factor=damping.stiffness_factor * least
        )
        kept = [own_ratio * (factor - least) for own_ratio, factor in zip(own, ratios, strict=True)]
    else:
        kept = [0.0] * n
    assumed = plant.ratios * ratios
    modal = tuple(float(max(a + b, 0.0)) for a, b in zip(kept, assumed, strict=True))
    if any(ratio > 0 for ratio in modal):
        damping = replace(damping, modal_ratios=modal)
    built = replace(structure, elements=elements, point_masses=points, dashpots=dashpots, damping=damping)
    return built.with_effects(*(f.cause for f in findings if isinstance(f.cause, Effect)))


def _normalised(plant: Plant) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    inverse = np.linalg.inv(np.linalg.cholesky(plant.mass))
    return np.asarray(inverse @ plant.stiffness @ inverse.T)
