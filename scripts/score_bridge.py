"""Score FE and hybrid model on the real bridge, each of its four recordings in turn kept for the test."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from fe_models.errors import bad_input_exits
from fe_models.files.atomic import write_json
from fe_models.files.bridge_recordings import RECORDINGS, write_bridge_dataset
from fe_models.files.dataset_file import load_dataset
from hybrid.config import Config, TrainingConfig
from hybrid.session import open_run, score, train

HEADER = """\
| test | trained on | FE measured | hybrid measured | FE A2 | hybrid A2 | hybrid, first 16 | hybrid A2, first 16 |
|---|---|---|---|---|---|---|---|"""

app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def main(
    data: Annotated[Path, typer.Argument(help="Folder with the authors' acc_measured1.mat to acc_measured4.mat.")],
    out: Annotated[Path, typer.Option(help="Folder for the four runs.")] = Path("runs/bridge_scores"),
    epochs: Annotated[int, typer.Option(min=1, help="Passes over the training windows.")] = TrainingConfig.epochs,
) -> None:
    """Train on three recordings of the real bridge, test on the fourth, for each of the four; A2 is never fitted.

    Prints NRMSE over all 500-sample windows of the test recording (stride 20), each forecast from its first 10 samples,
    and over the first 16 of them; writes OUT/scores.json. Takes about a minute a recording on two cores.
    """
    with bad_input_exits():
        config = Config(training=replace(Config().training, epochs=epochs))
        found: dict[str, Any] = {}
        for test in RECORDINGS:
            folder = out / f"test_{test}"
            dataset = load_dataset(write_bridge_dataset(data, folder, test))
            run = open_run(dataset, config, folder, "cpu", fresh=True)
            train(run)
            found[f"r{test}"] = score(run, dataset)
        write_json(out / "scores.json", found)
        print(HEADER)
        for name, metrics in found.items():
            print(row(name, metrics))


def row(test: str, metrics: dict[str, Any]) -> str:
    """Return one line of the table."""
    fe, hybrid = metrics["scores"]["fe"], metrics["scores"]["hybrid"]
    numbers = [model[role]["nrmse"] for role in ("measured", "held_out") for model in (fe, hybrid)]
    numbers += [hybrid[role]["nrmse_first_16_windows"] for role in ("measured", "held_out")]
    return (
        " | ".join([f"| {test}", ", ".join(metrics["training"]["recordings"]), *(f"{n:.3f}" for n in numbers)]) + " |"
    )


if __name__ == "__main__":
    app()
