"""The sub-command `benchmark` of `hybrid-modal`: everything that the product is measured against, in one run."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from benchmarks.row import Section
from hybrid.commands.console import command_line
from hybrid.commands.options import Quiet


def benchmark(
    out: Annotated[
        Path | None,
        typer.Option(
            help="Folder for the results. [default: runs/benchmark; with --certificate runs/certificate/COMMIT]"
        ),
    ] = None,
    modal_model: Annotated[
        Path | None, typer.Option(help="The chain's wrong modal model (.npz: omega, xi, phi). [default: drawn anew]")
    ] = None,
    recordings: Annotated[
        Path | None, typer.Option(help="Folder with the authors' acc_measured1..4.mat; without it no bridge.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the modal model that is drawn, or of the first blind case.")] = 0,
    blind: Annotated[
        int | None, typer.Option(min=1, help="Instead: this many cases with a hidden effect, diagnosed blind.")
    ] = None,
    rates: Annotated[
        int | None, typer.Option(min=1, help="Instead: so many of each noise and size, to see how the rates fall.")
    ] = None,
    kinds: Annotated[
        str | None,
        typer.Option(
            help="With --blind or --rates: what to hide in turn, by commas; 'a+b' for two, 'nothing'. [default: all]"
        ),
    ] = None,
    structure: Annotated[
        Literal["four_dof", "bridge"], typer.Option(help="With --blind or --rates: where effects are hidden.")
    ] = "four_dof",
    off: Annotated[bool, typer.Option("--off", help="With --blind: models off by their uncertainty.")] = False,
    noise: Annotated[float, typer.Option(min=0.0, help="With --blind: standard deviation over each channel's.")] = 0.03,
    noisy: Annotated[
        Literal["alike", "uneven", "unfiltered"],
        typer.Option(help="With --blind: noise alike in all recordings, in proportion to each, or after the low-pass."),
    ] = "alike",
    changed: Annotated[int, typer.Option(min=0, help="With --blind: recordings made before the last effect.")] = 0,
    step: Annotated[float | None, typer.Option(min=1e-6, help="With --blind: time steps of the bridge, s.")] = None,
    train: Annotated[
        int | None,
        typer.Option(min=1, help="With --blind: training recordings. [default: 9 of the chain, 3 of the bridge]"),
    ] = None,
    sensors: Annotated[
        int | None,
        typer.Option(min=1, help="With --blind: measured sensors, drawn. [default: 4 of the chain, 7 of the bridge]"),
    ] = None,
    peers: Annotated[bool, typer.Option(help="With --blind: have the peers answer, too.")] = True,
    jobs: Annotated[
        int | None,
        typer.Option(
            min=1,
            help="With --blind, --rates or --certificate: processes, one thread each. [default: 1; 2 of a certificate]",
        ),
    ] = None,
    certificate: Annotated[
        bool, typer.Option("--certificate", help="Instead: the certificate of this commit, about an hour on two cores.")
    ] = False,
    minutes: Annotated[
        float | None,
        typer.Option(min=0.0, help="With --certificate: begin no case after these; run again to go on. [default: all]"),
    ] = None,
    dirty: Annotated[
        bool, typer.Option("--dirty", help="With --certificate: run code that is not committed; the page says so.")
    ] = False,
    only: Annotated[
        list[Section] | None,
        typer.Option(help="This section only. Repeat for more."),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Less of everything, in under three minutes.")] = False,
    quiet: Quiet = False,
) -> None:
    """Measure accuracy and time on the paper's chain, the cost of a trajectory, and what each part of the model is for.

    Every number stands beside its peer's, measured in the same run unless marked as published. The authors' own modal
    model of the chain comes with their program; without --modal-model one that is wrong in the same way is drawn.
    Their recordings of the bridge come with it, too: --recordings adds it, about a quarter of an hour in all.

    With --blind, effects are hidden in simulated recordings and diagnosed before the truth is opened;
    beside the diagnosis stand exhaustive selection by AIC and sparse regression (PySINDy).

    With --certificate, 300 blind cases of each chain column and 120 of each bridge column (exact, and off by their
    uncertainty) are diagnosed. Each is kept as soon as it is done, so that the same command goes on after an
    interruption. Its seeds are for this alone: what it misses is counted, never looked into.

    \b
    OUT/benchmark.json         the table
    OUT/cost.png               seconds and memory against length, batch, modes and sensors
    OUT/blind.json             with --blind: the table, the confusion matrix, the calibration curve, every case
    OUT/blind_confusion.png    which kinds were hidden, which were named first
    OUT/blind_calibration.png  how many of the findings named at a probability are right
    OUT/blind_rates.json, .png with --rates: how the rates fall with noise and size
    OUT/cases/                 with --certificate: what is kept of each case
    docs/certificate.md, .json with --certificate: rates with intervals, probabilities and times, of the clone that runs
    """
    from benchmarks.blind import grid, runs
    from benchmarks.blind.cases import NOTHING, PEERS, tasks, words_of
    from benchmarks.blind_cases import OUTSIDE, BlindConfig
    from benchmarks.certificate.door import certify
    from benchmarks.sections import run_sections

    with command_line(quiet) as result:
        if certificate:
            certify(out, jobs or 2, minutes, dirty)
            result(Path("docs/certificate.md"))
            return
        out, jobs = out or Path("runs/benchmark"), jobs or 1
        if blind is not None:
            config = BlindConfig(
                off=off,
                noise=noise,
                noisy=noisy,
                train=train,
                measured=sensors,
                changed=changed,
                structure=structure,
                step=step,
            )
            cases = tasks(blind, seed, kinds.split(",") if kinds else words_of(structure), config)
            runs.run_blind(cases, tuple(PEERS) if peers else (), jobs, off, out)
            result(out / "blind.json")
            return
        if rates is not None:
            config = BlindConfig(off=off, structure=structure)
            inside = [word for word in words_of(structure) if word not in (NOTHING, *OUTSIDE)]
            cases = grid.grid_tasks(rates, seed, kinds.split(",") if kinds else inside, config)
            runs.run_rates(cases, jobs, out)
            result(out / "blind_rates.json")
            return
        run_sections(only or (), modal_model, recordings, seed, quick, out)
        result(out / "benchmark.json")
