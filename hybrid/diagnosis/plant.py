"""The nominal chain with what its user considers uncertain: M, C, K for any factors of springs, masses, modes."""

from dataclasses import dataclass

import numpy as np

from fe_models.assembly import linearise
from fe_models.damping import full_damping
from fe_models.dofs import DofMap, FloatArray
from fe_models.effects.base import ForceLaw
from fe_models.effects.laws import force_laws, with_parts
from fe_models.errors import InputError, raise_faults
from fe_models.nominal import damping_ratios
from fe_models.recordings import Dataset
from fe_models.structure import Spring, Structure
from fe_models.time_integration import TimeIntegration

CERTAIN = 1e-6  # the least standard deviation of a factor, so that a prior of zero stays a number


@dataclass(frozen=True)
class Plant:
    """A chain in physical coordinates.

    ``mass``, ``damping``, ``stiffness``: nominal (dof, dof), over the free degrees of freedom. ``springs``: each
    element's share in the stiffness (element, dof, dof). ``ratios``: assumed modal damping ratios (mode,) on top of
    ``damping``. ``spread``: prior standard deviations of the log factors of springs, masses and damping ratios, in this
    order (nuisance,). ``laws``: forces that the nominal structure itself has. ``integration``: the error of the user's
    own time steps, None where it integrates exactly.
    """

    structure: Structure
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    springs: FloatArray
    ratios: FloatArray
    spread: FloatArray
    laws: tuple[ForceLaw, ...]
    integration: TimeIntegration | None
    dofs: DofMap

    @property
    def size(self) -> int:
        """Number of free degrees of freedom."""
        return len(self.mass)

    def pull(self, law: ForceLaw) -> FloatArray:
        """Return the coefficients (dof,) of a law's elongation over the free degrees of freedom."""
        full = np.zeros(len(self.dofs))
        for node, direction, coefficient in law.pulls:
            full[self.dofs.row(node, direction)] += coefficient
        return full[self.dofs.free]


def plant_of(dataset: Dataset) -> Plant:
    """Return the nominal plant of a dataset; `InputError` where its model is none that a diagnosis can take yet."""
    structure = dataset.model
    if not isinstance(structure, Structure) or any(not isinstance(e, Spring) for e in structure.elements):
        raise InputError(
            "model: the diagnosis takes only chains so far (masses joined by springs in one direction);"
            " frames, trusses and bare matrices come later"
        )
    raise_faults(
        f"recording {recording.name!r} names loads: the diagnosis takes free vibrations only; leave it out"
        for recording in dataset.recordings
        if recording.loads
    )
    raise_faults(
        f"model: its own {law.kind} depends on time, which no recording tells; the diagnosis looks for it: take it out"
        for law in force_laws(structure)
        if law.timed
    )
    linear = linearise(structure)
    mass, stiffness = linear.mass.toarray(), linear.stiffness.toarray()
    assumed = dataset.assumptions
    if assumed.damping_ratio is None:
        damping, ratios = full_damping(linear), np.zeros(len(mass))
    else:
        damping, ratios = np.zeros_like(mass), damping_ratios(assumed.damping_ratio, len(mass))
    free = linear.dofs.free
    springs = []
    for element in with_parts(structure).elements:
        assert isinstance(element, Spring)  # effects of a chain add nothing else
        ends = np.zeros(len(linear.dofs))
        for node, sign in zip(element.nodes[::-1], (1.0, -1.0), strict=False):
            ends[linear.dofs.row(node, element.direction)] += sign
        springs.append(element.stiffness * np.outer(ends[free], ends[free]))
    normal = assumed.uncertainty
    spread = [normal.stiffness] * len(springs) + [normal.mass] * len(mass) + [normal.damping] * len(mass)
    newmark = assumed.integrator == "newmark" and assumed.step is not None
    return Plant(
        structure=structure,
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        springs=np.array(springs),
        ratios=ratios,
        spread=np.maximum(spread, CERTAIN),
        laws=force_laws(structure),
        integration=TimeIntegration(float(assumed.step)) if newmark and assumed.step is not None else None,
        dofs=linear.dofs,
    )
