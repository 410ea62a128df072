"""The sub-command `compare`: what recordings show by themselves."""

from pathlib import Path
from typing import Annotated

import typer

from hybrid.commands.console import command_line, print_notes, say, words_of
from hybrid.commands.options import DatasetFile, Out, Quiet

Extended = Annotated[
    str | None,
    typer.Option(
        help="A model beside the dataset's own, such as the extended_model.toml of a diagnosis: its frequency response "
        "functions are drawn and scored, too.",
        show_default=False,
    ),
]


def compare(dataset: DatasetFile, out: Out, extended: Extended = None, quiet: Quiet = False) -> None:
    """Compare the recordings of a dataset with the model's modes and with one another.

    Modes are identified from all channels of each recording, those held out elsewhere included: from free decays by
    fits of damped cosines, from ambient vibration by its correlations. Prints frequencies, damping and shapes of each
    recording beside the model's, with their standard deviations, and what changed from one recording to another; of
    free decays also how far the modes of one explain the others, how frequencies change while the motion decays, and
    peaks at sums and differences of frequencies. Of recordings under known loads or base motion it shows frequency
    response functions with coherence, beside the model's.

    \b
    OUT/report.html        all of it on a page for a browser, whole in one file: read this first
    OUT/comparison.txt     what is printed
    OUT/comparison.csv     one row per mode and recording: frequency, damping ratio, MAC, share of the energy
    OUT/comparison.json    the same with shapes, and all other numbers
    OUT/stabilisation.png  poles over the order of the system, from which modes were chosen
    OUT/mac.png            how alike the model's shapes and those of each recording are
    OUT/comac.png          the same sensor by sensor
    OUT/backbones.png      frequency against amplitude of the two strongest modes of free decays
    OUT/spectra.png        the recordings' spectra, with the model's frequencies
    OUT/frequency_response.png, .csv: the functions of recordings under known loads

    \b
    Example:
      hybrid-modal compare runs/data/dataset.toml --out runs/comparison
      hybrid-modal compare shaker.toml --out runs/functions --extended runs/found/extended_model.toml
    """
    from fe_models.errors import noting, raise_faults
    from fe_models.files.dataset_file import load_dataset
    from fe_models.files.inputs import files_read
    from fe_models.files.models import load_model
    from hybrid.identification.comparison_files import save_comparison
    from hybrid.identification.dataset_comparison import compare_dataset
    from hybrid.identification.frequency_response import extended_faults
    from hybrid.report.comparison_page import page_from_files
    from hybrid.report.page_files import save_page
    from hybrid.result_sets import comparison_in

    with command_line(quiet) as result:
        faults = list[str]()
        read = files_read(dataset, *([Path(extended)] if extended else []))
        noting(faults, "--out", comparison_in(out).check, read)
        data = noting(faults, "", load_dataset, dataset)
        beside = noting(faults, "--extended", load_model, extended) if extended else None
        if beside is not None and data is not None:
            faults += [f"--extended {extended}: {fault}" for fault in extended_faults(data, beside)]
        raise_faults(faults)
        assert data is not None  # else there were faults
        print_notes(data)
        found = compare_dataset(data, beside)
        sheets = save_comparison(found, out)
        print("".join(f"Note: {note}.\n" for note in found.notes) + found.text)
        given = words_of("compare", dataset, out) + (["--extended", extended] if extended else [])
        say(save_page(comparison_in(out), lambda: page_from_files(found, given, dataset, sheets)))
        print(f"\nResults: {out}")
        result(out)
