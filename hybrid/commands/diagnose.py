"""The sub-command `diagnose`: name what a simulation gets wrong, extend the model, measure the gain."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hybrid.commands.console import command_line, print_notes
from hybrid.commands.options import DatasetFile, Out, Quiet

if TYPE_CHECKING:
    from fe_models.recordings import Dataset

Hybrid = Annotated[
    bool,
    typer.Option(
        "--hybrid", help="Also train the hybrid model on the nominal and on the extended structure; takes minutes."
    ),
]
Modes = Annotated[
    bool,
    typer.Option(
        "--modes",
        help="By natural frequencies, damping ratios and mode shapes first: for a structure that may be far from its"
        " drawing, or has changed between recordings.",
    ),
]

HYBRID_OF_MATRICES = "a diagnosis of matrices makes no forecasts to train on; use hybrid-modal train"


def diagnose(
    dataset: DatasetFile, out: Out, hybrid: Hybrid = False, modes: Modes = False, quiet: Quiet = False
) -> None:
    """Diagnose a chain, a frame or matrices by groups from recordings.

    All causes of the list compete at all their places. What is found is built into the structure, and forecasts of the
    test recordings are scored before and after. A modal model that the dataset simulates with is held against the
    structure's own modes. The exit status is 0 once a report is written, whatever its verdict.

    With --modes the evidence is that of natural frequencies, damping ratios and shapes, and of how motion strays from
    them: it needs no nearly right model, tells how far groups of elements are off, what changed between recordings, and
    which force law acts. A dataset of identified modes alone ([[modes]]), and matrices by groups, are diagnosed so.

    \b
    OUT/report.json          verdict, findings with probabilities and alternatives, scores
    OUT/summary.txt          the same in words, as printed
    OUT/extended_model.toml  the structure with the findings, which every command accepts as a model
    OUT/what_is_wrong.png    a test recording beside both models' forecasts, and the spectra of their errors

    \b
    Example:
      hybrid-modal diagnose runs/chain/dataset.toml --out runs/chain/diagnosis
    """
    from fe_models.errors import InputError, noting, raise_faults
    from fe_models.files.dataset_file import load_dataset
    from fe_models.files.inputs import files_read
    from fe_models.linear import LinearModel
    from fe_models.progress import progress_bar, stage_bar
    from hybrid.diagnosis.stage_names import STAGE_NAMES
    from hybrid.result_sets import diagnosis_in

    with command_line(quiet) as result:
        faults = list[str]()
        noting(faults, "--out", diagnosis_in(out).check, files_read(dataset))
        if hybrid and modes:
            faults.append(
                "--modes: --hybrid trains on forecasts, of which modes alone make none; leave one of them out"
            )
        data = noting(faults, "", load_dataset, dataset, dead_channels=True)
        raise_faults(faults)
        assert data is not None  # else there were faults
        if hybrid and isinstance(data.model, LinearModel):
            raise InputError(f"--hybrid: {HYBRID_OF_MATRICES}")
        print_notes(data)
        if modes or (data.modes and not data.recordings) or isinstance(data.model, LinearModel):
            _diagnose_modes(data, out)
            result(out / "report.json")
            return
        with stage_bar(STAGE_NAMES) as begin:
            begin("loading")
            from hybrid.diagnosis import diagnosis  # only now: it takes longer to load than a mistake to be reported
            from hybrid.diagnosis.report import describe_diagnosis
            from hybrid.diagnosis.report_files import add_gain, save_diagnosis

            found = diagnosis.diagnose(data, begin)
        _say(save_diagnosis(found, out))  # now: the training below takes minutes
        gain = None
        if hybrid:
            from hybrid.diagnosis.learned.gain import hybrid_gain
            from hybrid.diagnosis.learned.learning import learning_preset

            epochs = 2 * learning_preset(data.model).training.epochs  # of two models
            with progress_bar("training hybrid models", epochs, "epoch") as bar:
                gain = hybrid_gain(data, found, advance=bar.update)
            add_gain(found, gain, out)
        print(describe_diagnosis(found, gain))
        print(f"Results: {out}")
        result(out / "report.json")


def _diagnose_modes(data: "Dataset", out: Path) -> None:
    """Diagnose by modes and motion, save the report and print it."""
    from fe_models.progress import stage_bar
    from hybrid.diagnosis.stage_names import MODAL_STAGES

    with stage_bar(MODAL_STAGES) as begin:
        begin("loading")
        from hybrid.diagnosis.joint.modal_diagnosis import diagnose_modes
        from hybrid.diagnosis.modal_report import describe_modal, save_modal_diagnosis

        seen = diagnose_modes(data, begin)
    _say(save_modal_diagnosis(seen, out))
    print(describe_modal(seen))
    print(f"Results: {out}")


def _say(notes: list[str]) -> None:
    """Say what could not be made beside the report."""
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
