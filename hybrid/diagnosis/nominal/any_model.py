"""The nominal model of a dataset whose model may be a structure, or matrices by groups."""

from dataclasses import replace

from fe_models.arrays import FloatArray
from fe_models.linear import LinearModel
from fe_models.recordings import Dataset
from hybrid.diagnosis.nominal.grouped_model import grouped_model_of, narrowed, rescaled
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.structure_model import nominal_model_of


def any_nominal_model_of(dataset: Dataset) -> NominalModel:
    """Return the nominal model of a dataset's structure, or of its matrices by groups; `InputError` without either."""
    if isinstance(dataset.model, LinearModel):
        return grouped_model_of(dataset)
    return nominal_model_of(dataset).undispersed


def with_parts_scaled(nominal: NominalModel, dataset: Dataset, factors: FloatArray) -> NominalModel:
    """Return the nominal model anew with its uncertain parts ``factors`` (part,) times as large."""
    if nominal.coordinates is not None:
        return rescaled(nominal, dataset, factors)
    structure = nominal.structure
    for part, factor in zip(nominal.parts, factors, strict=True):
        structure = part.scaled(structure, float(factor))
    return nominal_model_of(replace(dataset, model=structure)).undispersed


def followed_as_found(nominal: NominalModel, dataset: Dataset, highest: float) -> NominalModel:
    """Return the nominal model, of matrices followed no farther than the modes that were found ask for, up to
    ``highest`` (Hz).
    """
    return nominal if nominal.coordinates is None else narrowed(nominal, dataset, highest)
