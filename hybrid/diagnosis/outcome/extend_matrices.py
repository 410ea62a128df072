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
from fe_models.matrix_effects import KINDS
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.outcome.findings import Finding


@dataclass(frozen=True)
class ExtendedMatrices:
    """The ``calibrated`` matrices, and the ``effects`` that were found on top of them."""

    calibrated: LinearModel
    effects: tuple[Effect, ...]


def extended_matrices(nominal: NominalModel, theta: FloatArray, findings: tuple[Finding, ...]) -> ExtendedMatrices:
    """Return the matrices of the user, their groups calibrated by ``theta`` (nuisance,), and the findings on top.

    Damping ratios that are assumed, or come on top of C, are scaled as well; C itself stays.
    """
    assert nominal.coordinates is not None  # its caller has seen to that
    factors = np.exp(theta[: nominal.factors])
    named = [(part.quantity, part.group, float(own)) for part, own in zip(nominal.parts, factors, strict=False)]
    model, ratios = nominal.coordinates.scaled(named).drawn, factors[len(nominal.parts) :]
    if nominal.ratios.any():
        model = replace(model, modal_ratios=tuple(float(ratio) for ratio in nominal.ratios * ratios))
    found = (finding.cause for finding in findings)
    return ExtendedMatrices(model, tuple(cause for cause in found if isinstance(cause, KINDS)))


def save_extended_matrices(extended: ExtendedMatrices, path: Path, matrices: Path) -> None:
    """Write the extended model's file, and its ``matrices`` (.npz) in the same folder."""
    save_linear_model(extended.calibrated, matrices)
    document: Table = {"schema": 1, "matrices": {"file": matrices.name}}
    if extended.effects:
        document["effects"] = [effect_row(effect) for effect in extended.effects]
    write_text(path, toml_text(document))
