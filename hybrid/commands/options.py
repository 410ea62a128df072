"""Options that several commands take, each with its help."""

from pathlib import Path
from typing import Annotated

import typer

Model = Annotated[
    str,
    typer.Argument(
        help="four_dof or bridge (built in), a structure file (.toml), or matrices M, K, C (.npz, or a .toml that names"
        " them)."
    ),
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
    typer.Option(min=1, max=10_000, help="Finite elements per beam. [default: the divisions of the structure file]"),
]
Modes = Annotated[
    int | None, typer.Option(min=1, help="Natural modes, from the lowest. [default: 10, or all of a small model]")
]
Pictures = Annotated[bool, typer.Option(help="Draw the structure, with numbers, and its mode shapes.")]
Drawing = Annotated[bool, typer.Option("--pictures/--no-pictures", help="Draw the structure with its sensors.")]
Seed = Annotated[int, typer.Option(min=0, max=2**32 - 1, help="Of noise and random initial states.")]
