"""Measure the product against its peers, in one run: accuracy, time, cost, and what each part is for."""

from collections.abc import Callable
from dataclasses import asdict, replace
from enum import Enum
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import torch
import typer
from tqdm import tqdm

from benchmarks import ablations, bridge, chain, cost, speed
from benchmarks.blind import figures, grid, summary
from benchmarks.blind.cases import NOTHING, PEERS, BlindResult, Task, all_done, tasks, words_of
from benchmarks.blind.confusion import confusion
from benchmarks.blind.reliability import calibration
from benchmarks.blind_cases import OUTSIDE, BlindConfig, Noisy
from benchmarks.row import Row, table
from fe_models.built_in.four_dof import four_dof
from fe_models.dofs import structure_dofs
from fe_models.errors import bad_input_exits
from fe_models.files.atomic import write_json
from fe_models.files.modal_file import load_modal_model
from fe_models.linear import ModalModel
from hybrid.config import experts_preset, places_preset

STIFFNESSES = (0.0, 0.5, 1.0)  # k_n of the paper, N/m^3
QUICK_STIFFNESSES = (1.0,)
QUICK_MOTIONS = 120  # of which 24 are for testing, where the paper has 1000 and 200
QUICK_EPOCHS = 2  # of what is trained by gradients
QUICK_ABLATIONS = 60  # motions, a fifth of them for testing
VARIANTS = 5  # of the ablations
COST_PICTURE = "cost.png"


class Section(Enum):
    """A part of the benchmark."""

    CHAIN = "chain"
    SPEED = "speed"
    COST = "cost"
    ABLATIONS = "ablations"
    BRIDGE = "bridge"


app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def main(
    out: Annotated[Path, typer.Option(help="Folder for benchmark.json and the picture of the cost.")] = Path(
        "runs/benchmark"
    ),
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
        Noisy,
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
    jobs: Annotated[int, typer.Option(min=1, help="With --blind or --rates: processes, one thread each.")] = 1,
    only: Annotated[list[Section] | None, typer.Option(help="This section only. Repeat for more.")] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Less of everything, in under three minutes.")] = False,
) -> None:
    """Measure accuracy and time on the paper's chain, the cost of a trajectory, and what each part of the model is for.

    Every number stands beside its peer's, measured in the same run unless marked as published. The authors' own modal
    model of the chain comes with their program; without --modal-model one that is wrong in the same way is drawn.
    Their recordings of the bridge come with it, too: --recordings adds it, about a quarter of an hour in all.

    With --blind, effects are hidden in simulated recordings and diagnosed before the truth is opened;
    beside the diagnosis stand exhaustive selection by AIC and sparse regression (PySINDy).

    \b
    OUT/benchmark.json         the table
    OUT/cost.png               seconds and memory against length, batch, modes and sensors
    OUT/blind.json             with --blind: the table, the confusion matrix, the calibration curve, every case
    OUT/blind_confusion.png    which kinds were hidden, which were named first
    OUT/blind_calibration.png  how many of the findings named at a probability are right
    OUT/blind_rates.json, .png with --rates: how the rates fall with noise and size
    """
    with bad_input_exits():
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
            run_blind(cases, tuple(PEERS) if peers else (), jobs, off, out)
            return
        if rates is not None:
            config = BlindConfig(off=off, structure=structure)
            inside = [word for word in words_of(structure) if word not in (NOTHING, *OUTSIDE)]
            cases = grid.grid_tasks(rates, seed, kinds.split(",") if kinds else inside, config)
            run_rates(cases, jobs, out)
            return
        modal = modal_model_of(modal_model, seed)
        torch.set_num_threads(1)
        wanted = only or list(Section)
        found: list[Row] = []
        sections: dict[Section, Callable[[], list[Row]]] = {
            Section.CHAIN: lambda: chain_rows(modal, quick),
            Section.SPEED: lambda: speed.rows(modal),
            Section.COST: lambda: cost_rows(out, quick),
            Section.ABLATIONS: lambda: ablation_rows(modal, quick),
            Section.BRIDGE: lambda: bridge_rows(recordings, out, quick),
        }
        for section in wanted:
            found += sections[section]()
        write_json(out / "benchmark.json", {"schema": 1, "quick": quick, "rows": [asdict(row) for row in found]})
        print(table(found))
        print(f"Results: {out}")


def run_blind(wanted: list[Task], peers: tuple[str, ...], jobs: int, off: bool, out: Path) -> None:
    """Diagnose blind cases; print and draw how right that was. What is at hand is written after each case."""
    with tqdm(total=len(wanted), desc="Blind cases") as bar:

        def finished(found: list[BlindResult]) -> None:
            bar.update()
            if not found[-1].judgement.first:
                bar.write(found[-1].line)
            write_json(out / "blind.json", summary.content(found, off))

        results = all_done(wanted, peers, jobs, finished)
    write_json(out / "blind.json", summary.content(results, off))
    figures.draw_confusion(confusion(results), out / "blind_confusion.png")
    figures.draw_calibration(calibration(results), out / "blind_calibration.png")
    print(summary.text(results, off))
    print(f"Results: {out}")


def run_rates(wanted: list[Task], jobs: int, out: Path) -> None:
    """Diagnose cases of every noise and size; print and draw how the rates fall."""
    with tqdm(total=len(wanted), desc="Noise and size") as bar:
        results = all_done(wanted, (), jobs, lambda _: bar.update())
    cells = grid.cells(results)
    cases = [summary.case_content(result) for result in results]
    write_json(out / "blind_rates.json", {"schema": 1, "cells": [asdict(cell) for cell in cells], "cases": cases})
    figures.draw_grid(cells, out / "blind_rates.png")
    print(grid.table(cells))
    print(f"Results: {out}")


def modal_model_of(path: Path | None, seed: int) -> ModalModel:
    """Return the modal model in a file, or one that is wrong as the paper's is."""
    if path is None:
        return chain.own_modal_model(np.random.default_rng(seed))
    return load_modal_model(path, structure_dofs(four_dof()))


def chain_rows(modal: ModalModel, quick: bool) -> list[Row]:
    """Return accuracy and time on the paper's data for each of its k_n."""
    found = []
    for stiffness in QUICK_STIFFNESSES if quick else STIFFNESSES:
        with tqdm(desc=f"Chain, k_n = {stiffness:g}", unit="epoch", leave=False) as bar:
            motions = QUICK_MOTIONS if quick else chain.MOTIONS
            found += chain.rows(chain.score_chain(stiffness, modal, places_preset(), bar.update, motions))
    return found


def cost_rows(out: Path, quick: bool) -> list[Row]:
    """Return how the cost grows along each series; draw it."""
    series = cost.QUICK_SERIES if quick else cost.SERIES
    with tqdm(total=sum(map(len, series.values())), desc="Cost", leave=False) as bar:
        costs = cost.measure(series, bar.update)
    cost.draw(costs, out / COST_PICTURE)
    return cost.rows(costs)


def ablation_rows(modal: ModalModel, quick: bool) -> list[Row]:
    """Return what each part of the model is for."""
    with tqdm(total=VARIANTS, desc="Ablations", leave=False) as bar:
        if quick:
            return ablations.rows(modal, QUICK_EPOCHS, QUICK_ABLATIONS, bar.update)
        return ablations.rows(modal, advance=bar.update)


def bridge_rows(recordings: Path | None, out: Path, quick: bool) -> list[Row]:
    """Return the scores of the real bridge, each consistent recording in turn kept for the test."""
    if recordings is None:
        return []
    config = experts_preset()
    if quick:
        config = replace(config, training=replace(config.training, epochs=QUICK_EPOCHS))
    tests = bridge.CONSISTENT[:1] if quick else bridge.CONSISTENT
    return [
        row
        for test, metrics in bridge.score_splits(recordings, out / "bridge", tests, config)
        for row in bridge.rows(metrics, test)
    ]


if __name__ == "__main__":
    app()
