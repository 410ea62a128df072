"""Options that several commands take, each with its help."""

from pathlib import Path
from typing import Annotated

import typer

Model = Annotated[
    str, typer.Argument(help="four_dof, bridge, a structure (.toml), or your own M, K, C (.npz, or .toml on them).")
]
DatasetFile = Annotated[Path, typer.Argument(help="The dataset's TOML file.", show_default=False)]
Out = Annotated[Path, typer.Option(help="Folder for the results; made where it is missing.", show_default=False)]
Quiet = Annotated[
    bool,
    typer.Option("--quiet", "-q", help="Print nothing but warnings, errors and the path of the main result; no bars."),
]
Device = Annotated[str, typer.Option(help="cpu, cuda or cuda:N.")]

Refine = Annotated[
    int | None,
    typer.Option(min=1, max=10_000, help="Finite elements a beam, in place of the file's divisions. [default: these]"),
]
Modes = Annotated[
    int | None, typer.Option(min=1, help="Natural modes, from the lowest. [default: 10, or all of a small model]")
]
Pictures = Annotated[bool, typer.Option(help="Draw the structure, with numbers, and its mode shapes.")]
Drawing = Annotated[bool, typer.Option("--pictures/--no-pictures", help="Draw the structure with its sensors.")]
Seed = Annotated[int, typer.Option(min=0, max=2**32 - 1, help="Of noise and random initial states.")]
