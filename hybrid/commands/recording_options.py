"""The options on simulated recordings, which `simulate` and the script that builds a model take."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer


@dataclass(frozen=True)
class RecordingOptions:
    """The options as given; None where the choice is left to the program."""

    pull: Annotated[
        list[str] | None,
        typer.Option(
            help="A pull that is let go, NODE:DIRECTION:FORCE (N; N m for rz); several at once joined by +. Repeat for "
            "more recordings."
        ),
    ] = None
    base: Annotated[
        list[str] | None,
        typer.Option(
            help="Acceleration of the base, FILE[:COLUMN], one value per sample; from rest, without pulls. Repeat for "
            "more recordings."
        ),
    ] = None
    base_direction: Annotated[
        str | None, typer.Option(help="Direction of --base: x, y, or degrees from x towards y. [default: x]")
    ] = None
    base_unit: Annotated[str | None, typer.Option(help="Unit of --base: m/s^2, g or mm/s^2. [default: m/s^2]")] = None
    sensor: Annotated[
        list[str] | None,
        typer.Option(
            help="NODE:DIRECTION[:QUANTITY[:held_out]]; displacement, velocity or acceleration (the default); a "
            "direction also as degrees from x towards y (12:30) or a vector (12:3,4). Repeat for more sensors."
        ),
    ] = None
    realisations: Annotated[
        int | None, typer.Option(min=1, help="Chains: motions from random initial states. [default: 1000]")
    ] = None
    cubic_stiffness: Annotated[float | None, typer.Option(help="four_dof: cubic spring k_n at node 1, N/m^3.")] = None
    duration: Annotated[
        float | None, typer.Option(max=1e5, help="Length of a recording, s. [default: 20; chains 50]")
    ] = None
    step: Annotated[float | None, typer.Option(help="Integrator step, s. [default: what the highest mode needs]")] = (
        None
    )
    sampling_rate: Annotated[
        float | None, typer.Option(max=1e5, help="Sampling rate, Hz. [default: 100; chains 10]")
    ] = None
    lowpass: Annotated[
        float | None,
        typer.Option(
            help="Cutoff of the low-pass, Hz; 0 for none. [default: 0.3 times the sampling rate; none for chains and "
            "--base]"
        ),
    ] = None
    noise: Annotated[
        list[str] | None,
        typer.Option(
            help="Standard deviation of the noise: as a share of that of each channel (0.02), or with a unit "
            '("0.01 m/s^2"), repeated where sensors have several units. [default: 0.02]'
        ),
    ] = None
    gravity: Annotated[float | None, typer.Option(help="Gravity along -y, m/s^2. [default: 9.81]")] = None
    modal_model: Annotated[
        Path | None,
        typer.Option(help="four_dof: modal model (.npz: omega, xi, phi) that the dataset states as the simulation's."),
    ] = None

    def useless(self, *names: str, because: str) -> list[str]:
        """Return one fault for each of the options ``names`` that was given although it has no effect."""
        given = [name for name in names if getattr(self, name) is not None]
        return [f"--{name.replace('_', '-')}: {because}" for name in given]


NONE_GIVEN = RecordingOptions()
