"""The sub-command `diagnose`: name what a simulation gets wrong, extend the model, measure the gain."""

from typing import Annotated

import typer

from hybrid.commands.console import command_line, print_notes, say, words_of
from hybrid.commands.options import DatasetFile, Out, Quiet

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
        help="By natural frequencies, damping ratios, mode shapes and motion in any case: for a structure that may be"
        " far from its drawing. Left out, a first look at the modes decides.",
    ),
]

HYBRID_OF_MATRICES = "a diagnosis of matrices trains no hybrid models; use hybrid-modal train"


def diagnose(
    dataset: DatasetFile, out: Out, hybrid: Hybrid = False, modes: Modes = False, quiet: Quiet = False
) -> None:
    """Diagnose a chain, a frame or matrices by groups from recordings.

    All causes of the list compete at all their places. What is found is built into the structure, and forecasts of the
    test recordings are scored before and after. A modal model that the dataset simulates with is held against the
    structure's own modes. The exit status is 0 once a report is written, whatever its verdict.

    A structure that is nearly right is held against every sample. Where a first look shows that it is not, or that it
    changed between recordings, the evidence is that of natural frequencies, damping ratios and shapes, and of how
    motion strays from them: that tells how far groups of elements are off, what changed, and which force law acts.
    Recordings of wind and traffic, datasets of identified modes alone ([[modes]]) and matrices by groups are diagnosed
    so, too.

    \b
    OUT/report.html          all of it on a page for a browser, whole in one file: read this first
    OUT/report.json          verdict, findings with probabilities and alternatives, scores
    OUT/summary.txt          the same in words, as printed
    OUT/extended_model.toml  the structure with the findings, which every command accepts as a model
    OUT/what_is_wrong.png    a test recording beside both models' forecasts, and the spectra of their errors
    OUT/modes.png            measured modes beside the structure's, where these were the evidence

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
        data = noting(faults, "", load_dataset, dataset, dead_channels=True)
        raise_faults(faults)
        assert data is not None  # else there were faults
        if hybrid and isinstance(data.model, LinearModel):
            raise InputError(f"--hybrid: {HYBRID_OF_MATRICES}")
        print_notes(data)
        if hybrid and not data.recordings:
            raise InputError("--hybrid: training needs recordings, and the dataset has only modes; leave it out")
        with stage_bar(STAGE_NAMES) as begin:
            begin("loading")
            from hybrid.diagnosis import diagnosis  # only now: it takes longer to load than a mistake to be reported
            from hybrid.diagnosis.answer import answer_in_words
            from hybrid.diagnosis.joint.modal_diagnosis import diagnose_modes
            from hybrid.diagnosis.report_files import add_gain, save_diagnosis

            found = diagnose_modes(data, begin) if modes else diagnosis.diagnose(data, begin)
        say(save_diagnosis(found, out))  # now: the training below takes minutes
        gain = None
        if hybrid:
            from hybrid.diagnosis.learned.gain import hybrid_gain
            from hybrid.diagnosis.learned.learning import learning_preset

            epochs = 2 * learning_preset(data.model).training.epochs  # of two models
            with progress_bar("training hybrid models", epochs, "epoch") as bar:
                gain = hybrid_gain(data, found, advance=bar.update)
            add_gain(found, gain, out)
        given = words_of("diagnose", dataset, out)
        given += ["--hybrid"] * hybrid + ["--modes"] * modes
        from hybrid.report.diagnosis_page import page_from_files
        from hybrid.report.page_files import save_page

        say(save_page(diagnosis_in(out), lambda: page_from_files(found, data, given, dataset, gain)))
        print(answer_in_words(found, gain))
        print(f"Results: {out}")
        result(out / "report.json")
