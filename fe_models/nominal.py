"""The modal model that a dataset's own simulation assumes: the nominal model that measurements are compared with."""

from dataclasses import replace

import numpy as np

from fe_models.assembly import linearise
from fe_models.dofs import FloatArray
from fe_models.errors import InputError
from fe_models.linear import LinearModel, ModalModel
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset


def nominal_modes(dataset: Dataset, most: int) -> ModalModel:
    """Return at most ``most`` modes below the low-pass of the recordings, with the damping ratios that are assumed.

    The dataset's own modal model stands in for the structure's where it gives one; ``[simulation] modes`` goes before
    ``most``.
    """
    wanted = dataset.assumptions.modes or most
    given = dataset.assumptions.modal_model
    if given is None:
        model = dataset.model if isinstance(dataset.model, LinearModel) else linearise(dataset.model)
        given = natural_modes(model, min(wanted, model.mass.shape[0]))
    highest = dataset.lowpass or dataset.sampling_rate / 2
    kept = np.flatnonzero(given.frequencies < highest)[:wanted]  # a given modal model may have them in any order
    if len(kept) == 0:
        raise InputError(
            f"no natural frequency lies below {highest:g} Hz (the first is {given.frequencies.min():.4g} Hz):"
            " check sampling_rate and lowpass, or the units of the model"
        )
    assumed = dataset.assumptions.damping_ratio
    ratios = given.damping_ratio if assumed is None else damping_ratios(assumed, int(kept[-1]) + 1)
    return replace(given, omega=given.omega[kept], damping_ratio=ratios[kept], shapes=given.shapes[:, kept])


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
