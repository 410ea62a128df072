"""The nominal model of matrices by groups: what a search by modes asks of a structure, over few coordinates."""

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import SuperLU

from fe_models.arrays import FloatArray
from fe_models.damping import full_damping, ratios_of_modes, replace_ratios
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.mechanisms import describe_mechanism, factorise
from fe_models.nominal import refuse_none_in_band
from fe_models.recordings import Dataset
from fe_models.structure import TRANSLATIONS, Damping, Structure
from fe_models.uncertain_parts import UncertainPart
from hybrid.diagnosis.nominal.assumed_ratios import assumed_ratios
from hybrid.diagnosis.nominal.basis import followed_modes
from hybrid.diagnosis.nominal.config import COORDINATES, NOMINAL
from hybrid.diagnosis.nominal.coordinates import Coordinates, coordinates_of
from hybrid.diagnosis.nominal.lowpass import highest_shown, lowpass_of
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.scatter import NO_SCATTER

NO_GROUPS = (
    "model: bare matrices say nothing of springs, beams and supports, where causes sit, and these name no groups of"
    " elements: give the groups' shares of K and M (docs/matrices_file.md), or a structure file"
)


def grouped_model_of(dataset: Dataset, coordinates: Coordinates | None = None) -> NominalModel:
    """Return the nominal model of a dataset's matrices by groups; `InputError` where they have none.

    ``coordinates``: those to take, which the recordings need no others for; None: they are made.
    """
    lowpass = lowpass_of(dataset)
    highest = highest_shown(dataset, lowpass)
    if coordinates is None:
        coordinates = _coordinates(dataset, highest)
    model, assumed = coordinates.model, dataset.assumptions
    if assumed.damping_ratio is not None:
        model = replace(model, damping=csr_array(model.mass.shape), modal_ratios=(), replaced_ratios=())
    modal, kept = followed_modes(dataset, model, highest)
    modes = min(kept + NOMINAL.spare_damped_modes, len(modal.omega))
    damping = model.damping
    if model.replaced_ratios:
        damping = csr_array(full_damping(replace(model, modal_ratios=())))
    ratios = _ratios(model, assumed.damping_ratio, modes)
    parts, changes = _parts(model)
    normal = assumed.uncertainty
    spread = [getattr(normal, part.quantity) for part in parts] + [normal.damping] * modes
    turns = assumed.damping_ratio is None and bool(damping.count_nonzero())
    spread = [*np.maximum(spread, NOMINAL.least_std), *[NOMINAL.damping_turn_std] * turns]
    own = model.modal_ratios if assumed.damping_ratio is None else ()
    return NominalModel(
        structure=Structure("matrices", (), (), damping=Damping(modal_ratios=own)),
        mass=model.mass,
        damping=damping,
        stiffness=model.stiffness,
        dofs=model.dofs,
        basis=modal.shapes,
        kept=kept,
        parts=parts,
        part_changes=changes,
        ratios=ratios,
        scatter=NO_SCATTER,
        spread=np.array(spread),
        laws=(),
        integration=None,
        highest=highest,
        lowpass=lowpass,
        rate=dataset.sampling_rate,
        turns=turns,
        coordinates=coordinates,
    )


def rescaled(nominal: NominalModel, dataset: Dataset, factors: FloatArray) -> NominalModel:
    """Return the nominal model with its parts ``factors`` (part,) times as large, in the same coordinates."""
    assert nominal.coordinates is not None  # its caller has seen to that
    named = [(part.quantity, part.group) for part in nominal.parts]
    changed = [(*name, float(factor)) for name, factor in zip(named, factors, strict=True)]
    return _up_to(nominal.highest, dataset, nominal.coordinates.scaled(changed))


def narrowed(nominal: NominalModel, dataset: Dataset, highest: float) -> NominalModel:
    """Return the nominal model in the same coordinates, followed as far as is needed where modes were found up to
    ``highest`` (Hz): large models have modes without end below half the sampling rate.
    """
    assert nominal.coordinates is not None  # its caller has seen to that
    return _up_to(min(COORDINATES.reach * highest, nominal.highest), dataset, nominal.coordinates)


def _up_to(highest: float, dataset: Dataset, coordinates: Coordinates) -> NominalModel:
    as_sampled = replace(dataset, sampling_rate=2 * highest, lowpass=None, recordings=())
    return grouped_model_of(as_sampled, coordinates)


def _coordinates(dataset: Dataset, highest: float) -> Coordinates:
    model = dataset.model
    if not isinstance(model, LinearModel) or not model.groups:
        raise InputError(NO_GROUPS)
    factors = _factors_of_large(model)
    most = COORDINATES.most_modes if len(model.dofs.free_rows) > COORDINATES.most_whole else None
    modal, kept = followed_modes(dataset, model, highest, factors, most)
    if dataset.recordings:
        refuse_none_in_band(dataset, modal.frequencies)
    close = np.diff(modal.omega) < COORDINATES.min_separation * modal.omega[1:]
    # the span of the modes holds those of the parted model, too: they need not be solved for
    searched = parted(model) if close[:kept].any() else model
    return replace(coordinates_of(searched, modal, kept, dataset.sensors, factors), drawn=model)


def parted(model: LinearModel) -> LinearModel:
    """Return the model with a mass that differs a little from axis to axis: symmetrical structures have modes of equal
    frequency, whose shapes are any mixture, and change at once with the smallest change.
    """
    directions = model.dofs.direction[model.dofs.free]
    side = np.select([directions == axis for axis in TRANSLATIONS], [1.0, 0.0, -1.0], 0.0)
    scale = diags_array(1 + 0.5 * COORDINATES.parting_share * side)
    return replace(model, mass=csr_array(scale @ model.mass @ scale))


def _factors_of_large(model: LinearModel) -> SuperLU | None:
    """Return the factors of a large K, which take most of the time and are needed several times; None of others."""
    if model.stiffness.shape[0] < COORDINATES.most_whole:
        return None
    try:
        return factorise(model.stiffness)
    except RuntimeError:
        raise InputError(describe_mechanism(model)) from None


def _ratios(model: LinearModel, assumed: float | tuple[float, ...] | None, modes: int) -> FloatArray:
    """Return the damping ratios (mode,) on top of C; modes with a ratio of their own have it in C."""
    if assumed is None:
        own = ratios_of_modes(model.modal_ratios, modes)
        return replace_ratios(own, tuple((mode, 0.0) for mode, _ in model.replaced_ratios))
    return assumed_ratios(assumed, modes)


def _parts(model: LinearModel) -> tuple[tuple[UncertainPart, ...], tuple[csr_array, ...]]:
    """Return the groups' stiffnesses, then their masses, and what doubling each adds; less masses that nobody feels."""
    whole = float(model.mass.diagonal().sum())
    stiff = [group for group in model.groups if group.stiffness.nnz]
    heavy = [group for group in model.groups if group.mass.diagonal().sum() > NOMINAL.min_mass_share * whole]
    parts = [UncertainPart("stiffness", (), group=group.name) for group in stiff]
    parts += [UncertainPart("mass", (), group=group.name) for group in heavy]
    return tuple(parts), (*(group.stiffness for group in stiff), *(group.mass for group in heavy))
