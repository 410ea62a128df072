"""Matrices by groups with what was found built in: findings as effects, calibrated factors in the groups' shares."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import Effect
from fe_models.files.atomic import write_text
from fe_models.files.matrices_file import save_linear_model
from fe_models.files.structure_file import effect_row
from fe_models.files.tables import Table
from fe_models.files.toml_text import toml_text
from fe_models.linear import LinearModel
from fe_models.matrix_effects import KINDS, model_with_effects
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.outcome.findings import Finding


@dataclass(frozen=True)
class ExtendedMatrices:
    """The ``calibrated`` matrices, and the ``effects`` that were found on top of them; stiffness and mass of the
    drawn ones, and with what was found, over the few coordinates that were searched: ``drawn_in_few``,
    ``extended_in_few``.
    """

    calibrated: LinearModel
    effects: tuple[Effect, ...]
    drawn_in_few: LinearModel
    extended_in_few: LinearModel


def extended_matrices(
    nominal: NominalModel, offset: FloatArray, theta: FloatArray, findings: tuple[Finding, ...]
) -> ExtendedMatrices:
    """Return the matrices of the user, their groups calibrated by ``theta`` (nuisance,), and the findings on top;
    ``offset`` (nuisance,) of the nominal model from what the user drew.

    Damping ratios that are assumed, or come on top of C, are scaled as well; C itself stays.
    """
    assert nominal.coordinates is not None  # its caller has seen to that
    parts = len(nominal.parts)
    calibrated = nominal.coordinates.scaled(_scales(nominal, theta))
    drawn, model = nominal.coordinates.scaled(_scales(nominal, -offset)), calibrated.drawn
    if nominal.ratios.any():
        ratios = nominal.ratios * np.exp(theta[parts : nominal.factors])
        model = replace(model, modal_ratios=tuple(float(ratio) for ratio in ratios))
    found = (finding.cause for finding in findings)
    effects = tuple(cause for cause in found if isinstance(cause, KINDS))
    return ExtendedMatrices(model, effects, drawn.placed, model_with_effects(calibrated.placed, *effects))


def _scales(nominal: NominalModel, theta: FloatArray) -> list[tuple[str, str, float]]:
    """Return quantity, group and factor of each uncertain part, by the log factors ``theta`` (nuisance,)."""
    factors = np.exp(theta[: len(nominal.parts)])
    return [(part.quantity, part.group, float(own)) for part, own in zip(nominal.parts, factors, strict=True)]


def save_extended_matrices(extended: ExtendedMatrices, path: Path, matrices: Path) -> None:
    """Write the extended model's file, and its ``matrices`` (.npz) in the same folder."""
    save_linear_model(extended.calibrated, matrices)
    document: Table = {"schema": 1, "matrices": {"file": matrices.name}}
    if extended.effects:
        document["effects"] = [effect_row(effect) for effect in extended.effects]
    write_text(path, toml_text(document))
