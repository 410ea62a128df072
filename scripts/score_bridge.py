"""Score the hybrid model on the real bridge beside its peers, each of the four recordings in turn kept for the test."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from benchmarks.bridge import EXPANSIONS, score_splits
from fe_models.files.atomic import write_json
from fe_models.files.bridge_recordings import RECORDINGS
from hybrid.commands.console import command_line, new_app
from hybrid.config import Config, TrainingConfig, experts_preset

NAMES = {
    "fe": "FE model",
    "realisation": "eigensystem realisation",
    **{f"expansion_{modes}": f"modal expansion, {modes} modes" for modes in EXPANSIONS},
    "hybrid": "hybrid",
}
HEADER = """\
| test | trained on | model | measured, first 16 | measured, all | A2, first 16 | A2, all \
| in the 90 % band | A2 in the 90 % band | seconds |
|---|---|---|---|---|---|---|---|---|---|"""
NOTES = """\
NRMSE of 500-sample windows (stride 20), each forecast whole from its first 10 samples; R2 is in {path}.
Hybrid and FE model never see A2. The realisation (20 states, 20 block rows) is identified from all eight channels and
reads A2 too in a window's first samples; modal expansion is given the other seven at every instant."""

app = new_app()


@app.command()
def main(
    data: Annotated[Path, typer.Argument(help="Folder with the authors' acc_measured1.mat to acc_measured4.mat.")],
    out: Annotated[Path, typer.Option(help="Folder for the four runs.")] = Path("runs/bridge_scores"),
    epochs: Annotated[int, typer.Option(min=1, help="Passes over the training windows.")] = TrainingConfig.epochs,
    pooled: Annotated[bool, typer.Option("--pooled", help="One model of all training recordings, no experts.")] = False,
) -> None:
    """Train on three recordings of the real bridge, test on the fourth, for each of the four; A2 is never fitted.

    Prints NRMSE over all 500-sample windows of the test recording (stride 20), each forecast from its first 10 samples,
    and over the first 16 of them, beside the FE model, an identified linear model and modal expansion; how often all
    of them lie inside the hybrid's bands; and the seconds that a split's training takes. Writes OUT/scores.json. Each
    expert is trained once for all splits, which takes two to three minutes for each on a busy core.
    """
    with command_line(quiet=False):
        config = Config() if pooled else experts_preset()
        config = replace(config, training=replace(config.training, epochs=epochs))
        found = {f"r{test}": metrics for test, metrics in score_splits(data, out, RECORDINGS, config)}
        write_json(out / "scores.json", found)
        print(HEADER)
        for name, metrics in found.items():
            print("\n".join(rows(name, metrics)))
        print(NOTES.format(path=out / "scores.json"))


def rows(test: str, metrics: dict[str, Any]) -> list[str]:
    """Return a line of the table for each model."""
    recordings = ", ".join(metrics["training"]["recordings"])
    scores = {**metrics["scores"], **metrics["peers"]}
    lines = []
    for name, words in NAMES.items():
        numbers = [number for role in ("measured", "held_out") for number in _numbers(scores[name][role])]
        extra = _of_the_training(metrics) if name == "hybrid" else ["", "", ""]
        lines.append(f"| {' | '.join([test, recordings, words, *numbers, *extra])} |")
    return lines


def _numbers(averages: dict[str, float] | None) -> list[str]:
    """Return NRMSE over the first 16 windows and over all; nothing, where the model gives no such channel."""
    if averages is None:
        return ["", ""]
    return [f"{averages[key]:.3f}" for key in ("nrmse_first_16_windows", "nrmse")]


def _of_the_training(metrics: dict[str, Any]) -> list[str]:
    """Return how often all windows lie inside the hybrid's bands, measured channels and A2, and its seconds."""
    inside = metrics["bands"]["hybrid"]
    return [
        *(f"{100 * inside[role]:.1f} %" for role in ("measured", "held_out")),
        f"{metrics['training']['seconds']:.0f}",
    ]


if __name__ == "__main__":
    app()
