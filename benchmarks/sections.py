"""The sections of the benchmark: rows of its table, each beside its peer's number, measured in the same run."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import torch

from benchmarks import ablations, ambient_frame, bridge, chain, cost, loaded_chain, sampled_force, speed
from benchmarks.row import Row, Section, table
from fe_models.built_in.four_dof import four_dof
from fe_models.dofs import structure_dofs
from fe_models.errors import raise_faults
from fe_models.files.atomic import write_json
from fe_models.files.bridge_recordings import missing_recordings
from fe_models.files.modal_file import load_modal_model
from fe_models.linear import ModalModel
from fe_models.progress import progress_bar
from hybrid.config import experts_preset, places_preset

STIFFNESSES = (0.0, 0.5, 1.0)  # k_n of the paper, N/m^3
QUICK_STIFFNESSES = (1.0,)
LOADED_STIFFNESS = 1.0  # likewise, under known loads
QUICK_LOADED_MOTIONS = 20
QUICK_MOTIONS = 120  # of which 24 are for testing, where the paper has 1000 and 200
QUICK_EPOCHS = 2  # of what is trained by gradients
QUICK_ABLATIONS = 60  # motions, a fifth of them for testing
VARIANTS = 5  # of the ablations
COST_PICTURE = "cost.png"


def run_sections(
    wanted: Sequence[Section], modal_model: Path | None, recordings: Path | None, seed: int, quick: bool, out: Path
) -> None:
    """Measure the ``wanted`` sections, all where none is named; write and print the table."""
    raise_faults([] if recordings is None else missing_recordings(recordings))  # before minutes of other sections
    modal = modal_model_of(modal_model, seed)
    torch.set_num_threads(1)
    found: list[Row] = []
    sections: dict[Section, Callable[[], list[Row]]] = {
        Section.CHAIN: lambda: chain_rows(modal, quick),
        Section.LOADS: lambda: loaded_rows(modal, quick),
        Section.SAMPLED_FORCE: lambda: sampled_force.rows(quick),
        Section.AMBIENT_FRAME: lambda: ambient_frame_rows(quick),
        Section.SPEED: lambda: speed.rows(modal),
        Section.COST: lambda: cost_rows(out, quick),
        Section.ABLATIONS: lambda: ablation_rows(modal, quick),
        Section.BRIDGE: lambda: bridge_rows(recordings, out, quick),
    }
    for section in wanted or sections:
        found += sections[section]()
    write_json(out / "benchmark.json", {"schema": 1, "quick": quick, "rows": [asdict(row) for row in found]})
    print(table(found))
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
        config = places_preset()
        with progress_bar(f"Chain, k_n = {stiffness:g}", config.training.epochs, "epoch") as bar:
            motions = QUICK_MOTIONS if quick else chain.MOTIONS
            found += chain.rows(chain.score_chain(stiffness, modal, config, bar.update, motions))
    return found


def loaded_rows(modal: ModalModel, quick: bool) -> list[Row]:
    """Return accuracy under known random loads."""
    config, motions = places_preset(), QUICK_LOADED_MOTIONS if quick else loaded_chain.MOTIONS
    with progress_bar("Chain under loads", motions + config.training.epochs, "step") as bar:
        return loaded_chain.rows(loaded_chain.score_loaded_chain(LOADED_STIFFNESS, modal, config, motions, bar.update))


def ambient_frame_rows(quick: bool) -> list[Row]:
    """Return how well modes and a lost stiffness are found under ambient vibration."""
    pairs = ambient_frame.QUICK_PAIRS if quick else ambient_frame.PAIRS
    with progress_bar("Ambient frame", 2 * pairs, "pair") as bar:
        return ambient_frame.rows(pairs, bar.update)


def cost_rows(out: Path, quick: bool) -> list[Row]:
    """Return how the cost grows along each series; draw it."""
    series = cost.QUICK_SERIES if quick else cost.SERIES
    with progress_bar("Cost", sum(map(len, series.values())), "point") as bar:
        costs = cost.measure(series, bar.update)
    cost.draw(costs).save(out / COST_PICTURE)
    return cost.rows(costs)


def ablation_rows(modal: ModalModel, quick: bool) -> list[Row]:
    """Return what each part of the model is for."""
    with progress_bar("Ablations", VARIANTS, "variant") as bar:
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
