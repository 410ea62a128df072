"""The nominal model of a structure, in a basis of natural modes where it is a frame."""

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from fe_models.assembly import linearise, unsupported
from fe_models.causes import DeadLoad, LawWithMemory, MemorylessLaw, TimeIntegration
from fe_models.causes.laws import force_laws
from fe_models.causes.modal_damping import replaced_ratios
from fe_models.damping import full_damping, ratios_of_modes, replace_ratios
from fe_models.errors import InputError, raise_faults
from fe_models.recordings import Dataset
from fe_models.structure import Damping, Structure
from fe_models.uncertain_parts import UncertainPart, uncertain_parts
from hybrid.diagnosis.nominal.assumed_ratios import assumed_ratios
from hybrid.diagnosis.nominal.basis import basis_of
from hybrid.diagnosis.nominal.config import NOMINAL, SCATTER
from hybrid.diagnosis.nominal.loads import known_places
from hybrid.diagnosis.nominal.lowpass import highest_shown, lowpass_of
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.scatter import NO_SCATTER, scatter_of


def nominal_model_of(dataset: Dataset) -> NominalModel:
    """Return the nominal model of a dataset's structure; `InputError` where that is none that a diagnosis can take.

    Its modal model, where it has one, is another nominal model: see `modal_model`.
    """
    structure = dataset.model
    if not isinstance(structure, Structure):
        raise InputError(
            "model: bare matrices say nothing of springs, beams and supports, where causes sit: give a structure file,"
            " or diagnose matrices by groups by their modes"
        )
    laws = _own_laws(structure)
    assumed = dataset.assumptions
    if assumed.damping_ratio is not None:  # its own stands aside, what effects do to it stays: see `assumed_structure`
        structure = replace(structure, dashpots=(), damping=Damping())
    linear = linearise(structure)
    mass, damping, stiffness = unsupported(structure)
    if linear.replaced_ratios:
        settled = replace(linear, modal_ratios=())
        more = csr_array(full_damping(settled) - linear.damping.toarray()).tocoo()
        rows = linear.dofs.free_rows
        damping = damping + csr_array((more.data, (rows[more.row], rows[more.col])), shape=damping.shape)
    lowpass = lowpass_of(dataset)
    highest = highest_shown(dataset, lowpass)
    basis, kept = basis_of(dataset, linear, highest)
    modes = basis.shape[1] if kept is None else min(kept + NOMINAL.spare_damped_modes, basis.shape[1])
    ratios = ratios_of_modes(structure.damping.modal_ratios, modes)
    if assumed.damping_ratio is not None:
        ratios = assumed_ratios(assumed.damping_ratio, modes, whole=kept is None)
    ratios = replace_ratios(ratios, tuple((mode, 0.0) for mode, _ in replaced_ratios(structure)))  # as effects set them
    parts, changes = _felt_parts(structure)
    normal = assumed.uncertainty
    spread = [getattr(normal, part.quantity) for part in parts] + [normal.damping] * modes
    own_step = assumed.step if assumed.integrator == "newmark" else None
    nominal = NominalModel(
        structure=structure,
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        dofs=linear.dofs,
        basis=basis,
        kept=kept,
        parts=parts,
        part_changes=changes,
        ratios=ratios,
        scatter=NO_SCATTER,
        spread=np.maximum(spread, NOMINAL.least_std),
        laws=laws,
        integration=None if own_step is None else TimeIntegration(float(own_step)),
        loaded=known_places(dataset),
        highest=highest,
        lowpass=lowpass,
        rate=dataset.sampling_rate,
    )
    nominal = _scattered(nominal, normal.stiffness)
    turns = assumed.damping_ratio is None and bool(damping.count_nonzero())
    disperses = own_step is None
    spread = [*nominal.spread, *[NOMINAL.damping_turn_std] * turns, *[NOMINAL.dispersion_std] * disperses]
    return replace(nominal, spread=np.array(spread), turns=turns, disperses=disperses)


def _scattered(nominal: NominalModel, stiffness: float) -> NominalModel:
    """Return a frame's model with elements off by themselves; ``stiffness``: stated relative standard deviation."""
    if nominal.kept is None or not stiffness:
        return nominal
    omega, shapes = nominal.modes
    scatter = scatter_of(nominal.structure, nominal.parts, shapes, omega, nominal.own_ratios[: nominal.size])
    own = np.full(len(scatter.changes), max(SCATTER.element_std_share * stiffness, NOMINAL.least_std))
    return replace(nominal, scatter=scatter, spread=np.append(nominal.spread, own))


def _own_laws(structure: Structure) -> tuple[MemorylessLaw, ...]:
    """Return the force laws of a structure; `InputError` with those that a diagnosis cannot take along."""
    laws, faults = force_laws(structure), list[str]()
    for law in laws:
        if law.timed:
            faults.append(f"model: its own {law.kind} depends on time, which no recording shows")
        if isinstance(law, LawWithMemory):
            faults.append(f"model: its own {law.kind} has a memory, which a diagnosis does not take along")
    raise_faults(f"{fault}; the diagnosis looks for it: take it out" for fault in faults)
    return tuple(law for law in laws if isinstance(law, MemorylessLaw))


def _felt_parts(structure: Structure) -> tuple[tuple[UncertainPart, ...], tuple[csr_array, ...]]:
    """Return the uncertain parts and what doubling each adds to M or K, less those whose mass nothing feels.

    A dead load takes no part: what a heavier part makes of it is of second order.
    """
    effects = tuple(effect for effect in structure.effects if not isinstance(effect, DeadLoad))
    structure = replace(structure, effects=effects)
    mass, _, stiffness = unsupported(structure)
    parts, changes = [], []
    for part in uncertain_parts(structure):
        doubled = unsupported(part.scaled(structure, 2.0))
        change = csr_array(doubled[0] - mass if part.quantity == "mass" else doubled[2] - stiffness)
        if part.quantity == "stiffness" or change.diagonal().sum() > NOMINAL.min_mass_share * mass.diagonal().sum():
            parts.append(part)
            changes.append(change)
    return tuple(parts), tuple(changes)
