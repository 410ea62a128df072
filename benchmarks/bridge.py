"""The real bridge: the hybrid model beside an identified linear model and modal expansion, on recordings not fitted."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from benchmarks.row import Row
from fe_models.files.bridge_recordings import write_bridge_dataset
from fe_models.files.dataset_file import load_dataset
from fe_models.nominal import nominal_modes
from fe_models.recordings import Dataset
from hybrid.config import Config
from hybrid.estimation.modal_expansion import expand
from hybrid.estimation.windows import cut_all, window_length
from hybrid.identification.realisation import forecast_from_start, realise
from hybrid.training.evaluation import score_table
from hybrid.training.expert_reuse import TrainedExpert, take_over, train_expert
from hybrid.training.session import open_run, score, train

EXPANSIONS = (4, 10)  # modes: as few as are well known, and all that lie below the low-pass
SPANS = {"nrmse_first_16_windows": "first 16 windows", "nrmse": "all windows"}
AIMS = {"nrmse_first_16_windows": "0.055", "nrmse": "0.075"}
CONSISTENT = (1, 3, 4)  # recordings of one structure; the second is another's


def score_splits(data: Path, out: Path, tests: Sequence[int], config: Config) -> Iterator[tuple[int, dict[str, Any]]]:
    """Yield each of ``tests`` with its metrics and its peers': that recording of ``data`` to test, three to train.

    An expert is trained once for all splits; the seconds of a split are those of all its experts all the same.
    """
    experts: dict[str, TrainedExpert] = {}
    for test in tests:
        folder = out / f"test_{test}"
        dataset = load_dataset(write_bridge_dataset(data, folder, test))
        run = open_run(dataset, config, folder, "cpu", fresh=True)
        if config.model.experts:
            for name in run.origin.kept:
                if name not in experts:
                    experts[name] = train_expert(dataset, name, config, out / f"expert_{name}")
            take_over(run, [experts[name] for name in run.origin.kept])
        else:
            train(run)
        metrics = score(run, dataset).metrics
        yield test, {**metrics, "peers": peer_scores(dataset, metrics["training"]["recordings"], config)}


def peer_scores(dataset: Dataset, kept: list[str], config: Config) -> dict[str, Any]:
    """Return the scores of eigensystem realisation and modal expansion on the hybrid's test windows.

    The realisation is identified from the recordings that the hybrid ``kept``; of modal expansion only the held-out
    sensor is scored.
    """
    samples = config.model.encoder_samples
    length = window_length(dataset, config)
    windows = cut_all(dataset.select("test"), length, config.training.stride)
    model = realise([recording.data for recording in dataset.recordings if recording.name in kept])
    modal = nominal_modes(dataset, config.model.modes)
    forecasts = {
        "realisation": forecast_from_start(model, windows, samples),
        **{f"expansion_{modes}": expand(modal, dataset.sensors, windows, modes) for modes in EXPANSIONS},
    }
    tables = score_table(forecasts, windows, dataset.sensors)
    return {
        name: table if name == "realisation" else {"measured": None, "held_out": table["held_out"]}
        for name, table in tables.items()
    }


def rows(metrics: dict[str, Any], test: int) -> list[Row]:
    """Return the lines of one split, the hybrid beside its peers."""
    section, scores, peers = f"bridge, test r{test}", metrics["scores"], metrics["peers"]
    found = []
    for key, span in SPANS.items():
        hybrid, era = scores["hybrid"]["measured"][key], peers["realisation"]["measured"][key]
        found.append(Row(section, f"NRMSE, {span}", hybrid, "eigensystem realisation", era, aim=AIMS[key]))
        hybrid = scores["hybrid"]["held_out"][key]
        found.append(
            Row(section, f"A2, {span}", hybrid, "realisation, A2 fitted", peers["realisation"]["held_out"][key])
        )
        for modes in EXPANSIONS:
            found.append(
                Row(
                    section,
                    f"A2, {span}",
                    hybrid,
                    f"expansion, {modes} modes, others known",
                    peers[f"expansion_{modes}"]["held_out"][key],
                )
            )
    found.append(Row(section, "R2 of the measured channels", scores["hybrid"]["measured"]["r2"]))
    inside = metrics["bands"]["hybrid"]
    found.append(Row(section, "inside the 90 % band, measured", inside["measured"], aim="0.87-0.93"))
    found.append(Row(section, "inside the 90 % band, A2", inside["held_out"]))
    found.append(Row(section, "seconds of training", metrics["training"]["seconds"], aim="600"))
    return found
