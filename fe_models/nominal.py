"""The modal model that a dataset's own simulation assumes: the nominal model that measurements are compared with."""

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.errors import InputError
from fe_models.linear import LinearModel, ModalModel
from fe_models.mode_count import mode_count
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset
from fe_models.structure import Damping, Structure


def assumed_structure(dataset: Dataset) -> Structure | LinearModel:
    """Return the dataset's model with the damping that its user assumes.

    ``[simulation] damping_ratio`` stands in place of a structure's own damping: its dashpots and what belongs to it as
    a whole. What effects do to the damping (a damper, the ratio of a mode) is a known deviation and stays. Of matrices
    it stands in place of all of C.
    """
    model, ratio = dataset.model, dataset.assumptions.damping_ratio
    if ratio is None:
        return model
    ratios = ratio if isinstance(ratio, tuple) else (ratio,)
    if isinstance(model, LinearModel):
        return replace(model, damping=csr_array(model.mass.shape), modal_ratios=ratios, replaced_ratios=())
    return replace(model, dashpots=(), damping=Damping(modal_ratios=ratios))


def nominal_modes(dataset: Dataset, most: int) -> ModalModel:
    """Return at most ``most`` modes below the low-pass of the recordings, with the damping ratios that are assumed.

    The dataset's own modal model stands in for the structure's where it gives one; ``[simulation] modes`` goes before
    ``most``.
    """
    wanted = dataset.assumptions.modes or most
    given = dataset.assumptions.modal_model
    if given is None:
        subject = assumed_structure(dataset)
        model = subject if isinstance(subject, LinearModel) else linearise(subject)
        given = natural_modes(model, dataset.assumptions.modes or min(most, mode_count(model)))
    refuse_none_in_band(dataset, given.frequencies)
    kept = np.flatnonzero(given.frequencies < _highest(dataset))[:wanted]  # a given modal model may have any order
    ratios = given.damping_ratio
    if dataset.assumptions.damping_ratio is not None:
        listed = damping_ratios(dataset.assumptions.damping_ratio, int(kept[-1]) + 1)
        own = dataset.assumptions.modal_model is None and isinstance(dataset.model, Structure)
        ratios = ratios if own else listed  # a structure's own modes have them already, and what its effects add
    return replace(given, omega=given.omega[kept], damping_ratio=ratios[kept], shapes=given.shapes[:, kept])


def require_mode_in_band(dataset: Dataset) -> None:
    """Raise `InputError` where recordings cannot show a single mode of the model: a wrong rate, or wrong units.

    Matrices by groups, whose modes may take minutes, are checked where these are solved for.
    """
    grouped = isinstance(dataset.model, LinearModel) and bool(dataset.model.groups)
    if dataset.recordings and (not grouped or dataset.assumptions.modal_model is not None):
        nominal_modes(dataset, 1)


def refuse_none_in_band(dataset: Dataset, frequencies: FloatArray) -> None:
    """Raise `InputError` where none of the model's ``frequencies`` (mode,) Hz is one that recordings go up to."""
    highest = _highest(dataset)
    if not (frequencies < highest).any():
        raise InputError(
            f"no natural frequency lies below {highest:g} Hz (the first is {frequencies.min():.4g} Hz):"
            " check sampling_rate and lowpass, or the units of the model"
        )


def _highest(dataset: Dataset) -> float:
    """Return the frequency (Hz) up to which recordings go."""
    return dataset.lowpass or dataset.sampling_rate / 2


def damping_ratios(assumed: float | tuple[float, ...], count: int) -> FloatArray:
    """Return the damping ratios (mode,) of the first ``count`` modes, from one number or a list."""
    ratios = np.atleast_1d(np.asarray(assumed, dtype=float))
    if len(ratios) == 1:
        return np.full(count, ratios[0])
    if len(ratios) < count:
        raise InputError(
            f"[simulation] damping_ratio lists {len(ratios)} values for {count} modes: one each, or one for all"
        )
    return ratios[:count]
