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

Refine = Annotated[int, typer.Option(min=1, max=10_000, help="Finite elements per beam.")]
Modes = Annotated[
    int | None, typer.Option(min=1, help="Natural modes, from the lowest. [default: 10, or all of a small model]")
]
Pictures = Annotated[bool, typer.Option(help="Draw the structure, with numbers, and its mode shapes.")]
Drawing = Annotated[bool, typer.Option("--pictures/--no-pictures", help="Draw the structure with its sensors.")]

Pull = Annotated[
    list[str] | None,
    typer.Option(help="NODE:DIRECTION:FORCE (N; N m for rz) let go, several joined by +. Repeat for more recordings."),
]
SensorAt = Annotated[
    list[str] | None, typer.Option(help="NODE:DIRECTION[:QUANTITY[:held_out]], acceleration unless given. Repeat.")
]
Realisations = Annotated[
    int | None, typer.Option(min=1, help="Chains: motions from random initial states. [default: 1000]")
]
CubicStiffness = Annotated[float | None, typer.Option(help="four_dof: cubic spring k_n at node 1, N/m^3.")]
Duration = Annotated[float | None, typer.Option(max=1e5, help="Length of a recording, s. [default: 20; chains 50]")]
Step = Annotated[float | None, typer.Option(help="Integrator step, s. [default: 0.001; chains 0.05]")]
SamplingRate = Annotated[float | None, typer.Option(max=1e5, help="Hz. [default: 100; chains 10]")]
LowPassAt = Annotated[float | None, typer.Option(help="Hz, 0 for none. [default: 30; chains none]")]
Noise = Annotated[
    list[str] | None,
    typer.Option(
        help='Standard deviation: over that of each channel (0.02), or with a unit ("0.01 m/s^2"), repeated where '
        "sensors have several units. [default: 0.02]"
    ),
]
Gravity = Annotated[float | None, typer.Option(help="m/s^2, along -y. [default: 9.81]")]
ModalModelFile = Annotated[
    Path | None, typer.Option(help="four_dof: modal model (.npz: omega, xi, phi) that the dataset is given.")
]
Seed = Annotated[int, typer.Option(min=0, max=2**32 - 1, help="Of noise and random initial states.")]
Simulate = Annotated[bool, typer.Option("--simulate", help="Also write simulated recordings, OUT/dataset.toml.")]
