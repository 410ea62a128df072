"""Find a model by what a user writes for it: a built-in structure, or a file."""

from collections.abc import Callable
from pathlib import Path

from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.errors import InputError
from fe_models.files.matrices_file import load_linear_model
from fe_models.files.matrix_market import parse_matrices
from fe_models.files.structure_file import parse_structure
from fe_models.files.tables import did_you_mean, read_toml
from fe_models.linear import LinearModel
from fe_models.structure import Structure

BUILT_IN: dict[str, Callable[[], Structure]] = {"four_dof": four_dof, "bridge": bridge}


def load_model(spec: str, folder: Path = Path()) -> Structure | LinearModel:
    """Return the model that ``spec`` names: a built-in one, or a .toml or .npz path relative to ``folder``.

    A .toml file holds a structure, or names matrices (`matrix_market`). `InputError` carries all faults.
    """
    if spec in BUILT_IN:
        return BUILT_IN[spec]()
    path = folder / spec
    if path.suffix.lower() == ".npz":
        return load_linear_model(path)
    if path.suffix.lower() != ".toml":
        hint = did_you_mean(spec, BUILT_IN)
        raise InputError(f"model {spec!r} is unknown{hint}; or give a .toml or .npz file")
    document = read_toml(path)
    if "matrices" in document:
        return parse_matrices(document, path.parent, path.name)
    return parse_structure(document, path.name)
