"""The options of the benchmark, by what it measures."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import typer

from benchmarks.row import Section


@dataclass(frozen=True)
class SectionOptions:
    """Options on the sections of the table."""

    modal_model: Annotated[
        Path | None, typer.Option(help="The chain's wrong modal model (.npz: omega, xi, phi). [default: drawn anew]")
    ] = None
    recordings: Annotated[
        Path | None, typer.Option(help="Folder with the authors' acc_measured1..4.mat; without it no bridge.")
    ] = None
    only: Annotated[list[Section] | None, typer.Option(help="This section only. Repeat for more.")] = None
    quick: Annotated[bool, typer.Option("--quick", help="Less of everything, in under three minutes.")] = False


@dataclass(frozen=True)
class BlindOptions:
    """Options on blind cases."""

    blind: Annotated[
        int | None, typer.Option(min=1, help="Instead: this many cases with a hidden effect, diagnosed blind.")
    ] = None
    next: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="Instead: this many cases that few sensors leave open, measured again as advised and at random.",
        ),
    ] = None
    rates: Annotated[
        int | None, typer.Option(min=1, help="Instead: this many cases of each noise and size: how the rates fall.")
    ] = None
    kinds: Annotated[
        str | None,
        typer.Option(
            help="With --blind or --rates: what to hide in turn, by commas; 'a+b' for two, 'nothing'. [default: all]"
        ),
    ] = None
    structure: Annotated[
        Literal["four_dof", "bridge"], typer.Option(help="With --blind or --rates: where effects are hidden.")
    ] = "four_dof"
    tier: Annotated[
        Literal["exact", "off", "far"] | None,
        typer.Option(
            help="With --blind or --rates: models exact, off by their uncertainty, or far: groups off by 10 to 40 %, "
            "where 1 and 10 % are stated. [default: exact]"
        ),
    ] = None
    off: Annotated[bool, typer.Option("--off", help="The same as --tier off.")] = False
    acts: Annotated[
        Literal["all", "one"],
        typer.Option(help="With --blind or --rates: the effect in all recordings, or in the last for training alone."),
    ] = "all"
    excitation: Annotated[
        Literal["free", "ambient", "measured", "base"],
        typer.Option(
            help="With --blind or --rates: what moves the structure: its state alone, unknown forces for minutes "
            "(diagnosed by modes), recorded forces, or a recorded motion of its base; the last two of the chain alone."
        ),
    ] = "free"
    noise: Annotated[
        float, typer.Option(min=0.0, help="With --blind: standard deviation of the noise over that of each channel.")
    ] = 0.03
    noisy: Annotated[
        Literal["alike", "uneven", "unfiltered"],
        typer.Option(help="With --blind: noise alike in all recordings, in proportion to each, or after the low-pass."),
    ] = "alike"
    changed: Annotated[
        int, typer.Option(min=0, help="With --blind: how many recordings are made before the last effect comes.")
    ] = 0
    step: Annotated[float | None, typer.Option(min=1e-6, help="With --blind: time steps of the bridge, s.")] = None
    train: Annotated[
        int | None,
        typer.Option(min=1, help="With --blind: training recordings. [default: 9 of the chain, 3 of the bridge]"),
    ] = None
    test: Annotated[
        int | None,
        typer.Option(
            min=0, help="With --blind: recordings for testing. [default: 3 of the chain, 1 of the bridge; 0 of ambient]"
        ),
    ] = None
    sensors: Annotated[
        int | None,
        typer.Option(min=1, help="With --blind: measured sensors, drawn. [default: 4 of the chain, 7 of the bridge]"),
    ] = None
    peers: Annotated[bool, typer.Option(help="With --blind: have the peers answer, too, of free vibration.")] = True


@dataclass(frozen=True)
class CertificateOptions:
    """Options on the certificate."""

    certificate: Annotated[
        bool,
        typer.Option("--certificate", help="Instead: the certificate of this commit; ten hours and more on two cores."),
    ] = False
    minutes: Annotated[
        float | None,
        typer.Option(
            min=0.0,
            help="With --certificate: begin no case after this many minutes; run again to go on. [default: all]",
        ),
    ] = None
    dirty: Annotated[
        bool, typer.Option("--dirty", help="With --certificate: run code that is not committed; the page says so.")
    ] = False


@dataclass(frozen=True)
class AuditOptions:
    """Options on the audit."""

    audit: Annotated[
        bool,
        typer.Option("--audit", help="Instead: evidences against nested sampling, ranks of posteriors; 20 minutes."),
    ] = False


SECTIONS, BLIND, CERTIFICATE, AUDIT = SectionOptions(), BlindOptions(), CertificateOptions(), AuditOptions()
