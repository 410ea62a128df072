"""The sub-command `inspect`: what is in a recording file."""

from pathlib import Path
from typing import Annotated

import typer

from hybrid.commands.console import command_line
from hybrid.commands.options import Quiet

RecordingPath = Annotated[
    Path,
    typer.Argument(
        metavar="FILE", help="A recording: .csv, .txt, .mat, .npz, .npy, .uff, .unv or .tdms.", show_default=False
    ),
]
OptionalOut = Annotated[
    Path | None, typer.Option("--out", help="Folder for the results; made where it is missing.", show_default=False)
]
Key = Annotated[str | None, typer.Option("--key", help="The array's name, where the file holds several.")]
Rate = Annotated[
    float | None,
    typer.Option("--sampling-rate", min=1e-6, help="Hz, where the file does not say it.", show_default=False),
]


def inspect(
    file: RecordingPath, out: OptionalOut = None, key: Key = None, sampling_rate: Rate = None, quiet: Quiet = False
) -> None:
    """Say what is in a recording file, and write a dataset to start from.

    Names and units of the channels, sampling rate, length, ranges, lost samples, clipping, drift, sensors that were
    stuck or dead, the strongest peaks of the spectra, and what seems to have moved the structure. Without --out nothing
    is written.

    \b
    OUT/dataset.toml     a dataset on the file, with CHECK where only you know
    OUT/inspection.txt   what is printed
    OUT/inspection.json  the same for other programs
    OUT/inspection.png   each channel over time, and its spectrum

    \b
    Example:
      hybrid-modal inspect monday.csv --out runs/monday
    """
    from fe_models.errors import noting, raise_faults
    from hybrid.inspection.inspection import inspect_file
    from hybrid.inspection.inspection_files import inspection_in, save_inspection
    from hybrid.inspection.inspection_report import describe

    with command_line(quiet) as result:
        faults = list[str]()
        if out is not None:
            noting(faults, "--out", inspection_in(out).check, [file])
        found = noting(faults, "", inspect_file, file, key, sampling_rate)
        raise_faults(faults)
        assert found is not None  # else there were faults
        print(describe(found))
        if out is not None:
            dataset = save_inspection(found, out)
            print(f"\nA dataset to start from: {dataset} (fill in what says CHECK)\nResults: {out}")
            result(dataset)
