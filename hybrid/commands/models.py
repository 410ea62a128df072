"""Models as the commands load, write and print them."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import PAPER_FREQUENCIES
from fe_models.built_in.four_dof import PAPER_OMEGA
from fe_models.causes.dead_load import dead_load_share
from fe_models.damping import full_damping
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.inputs import files_read
from fe_models.files.matrices_file import LARGEST_DENSE
from fe_models.files.models import load_model
from fe_models.files.result_set import ResultSet
from fe_models.files.run_folder import MODEL, save_run_model
from fe_models.files.structure_file import save_structure
from fe_models.linear import LinearModel, ModalModel
from fe_models.modes import natural_modes
from fe_models.recordings import Sensor
from fe_models.structure import Structure

STRUCTURE = "structure.toml"
DRAWING = "structure.png"
NO_DAMPING = (
    "Note: the model has no damping, so that its motion never dies away; give it some, for example "
    "damping = { modal_ratios = 0.01 } at the top of the structure file, 1 % of critical in each mode."
)


def model_in(folder: Path) -> ResultSet:
    """Return what `write_model` leaves in ``folder``."""
    return ResultSet(folder, "build", (MODEL, STRUCTURE, DRAWING, "mode_[0-9]*.png", "modes.png"))


def open_model(
    spec: str, refine: int | None, results: Iterable[ResultSet], modal_model: Path | None = None
) -> Structure | LinearModel:
    """Return `refined_model`; `InputError` with its faults, and with those of ``results`` where they must not go."""
    faults, read = list[str](), files_read(Path(spec), *([modal_model] if modal_model else []))
    for each in results:
        noting(faults, "--out", each.check, read)
    model = noting(faults, "", refined_model, spec, refine)
    raise_faults(dict.fromkeys(faults))
    assert model is not None  # else there were faults
    return model


def refined_model(spec: str, refine: int | None) -> Structure | LinearModel:
    """Return the model that ``spec`` names, relative to the working folder.

    ``refine``: finite elements of each beam, in place of those that the file asks for.
    """
    subject = load_model(spec, Path())
    if refine is None:
        return subject
    if isinstance(subject, Structure):
        return subject.refined(refine)
    if refine > 1:
        raise InputError(f"{spec} holds matrices only: --refine needs a structure (.toml)")
    return subject


def write_model(
    spec: str,
    subject: Structure | LinearModel,
    results: ResultSet,
    modes: int | None,
    pictures: bool,
    sensors: Sequence[Sensor] = (),
) -> None:
    """Write a model, that ``spec`` names, and its ``modes`` as ``results``; print its natural frequencies.

    Its drawing shows ``sensors`` where they are known.
    """
    linear = subject if isinstance(subject, LinearModel) else linearise(subject)
    size = linear.mass.shape[0]
    modal = natural_modes(linear, modes)
    if linear.has_modal_damping and size <= LARGEST_DENSE:  # C complete where it can be
        linear = replace(linear, damping=csr_array(full_damping(linear)), modal_ratios=(), replaced_ratios=())
    with results.replacing() as new:
        save_run_model(subject, modal, new, linear)
        if isinstance(subject, Structure):
            save_structure(subject, new / STRUCTURE)
    print(f"{size} free degrees of freedom; matrices and modes: {results.folder / MODEL}")
    print(f"Natural modes {described(subject)}:")
    print(frequency_table(modal, paper_frequencies(spec)))
    if not modal.damping_ratio.any():
        print(NO_DAMPING)
    if pictures:
        from fe_models.pictures.render import draw_modes, draw_structure  # graphics, only where they are needed

        with results.adding() as new:
            draw_structure(subject, new / DRAWING, sensors)
            overview = draw_modes(subject, modal, new)[-1]
        print(f"Nodes and elements with their numbers: {results.folder / DRAWING}")
        print(f"Mode shapes: {results.folder / overview.name}")


def paper_frequencies(model: str) -> FloatArray:
    """Return the frequencies (Hz) that the paper gives for a built-in structure, else none."""
    known = {"bridge": np.array(PAPER_FREQUENCIES), "four_dof": np.array(PAPER_OMEGA) / (2 * np.pi)}
    return known.get(model, np.zeros(0))


def described(subject: Structure | LinearModel) -> str:
    """Return about which state a model moves, in words."""
    loaded = isinstance(subject, Structure) and dead_load_share(subject) > 0
    return "about the state at rest under weight and prestress" if loaded else "without loads and prestress"


def frequency_table(modal: ModalModel, paper: FloatArray) -> str:
    """Return the modes as a table, beside the paper's frequencies where there are any."""
    lines = ["mode   frequency   damping ratio" + ("   paper" if len(paper) else "")]
    for number, (frequency, ratio) in enumerate(zip(modal.frequencies, modal.damping_ratio, strict=True), start=1):
        line = f"{number:4d}   {frequency:6.4f} Hz   {100 * ratio:z11.3f} %"
        known = paper[number - 1 : number]
        lines.append(line + "".join(f"   {value:.4f} Hz ({100 * (frequency / value - 1):+.3f} %)" for value in known))
    return "\n".join(lines)
