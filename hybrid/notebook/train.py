"""Train the hybrid model in one call."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from fe_models.files.inputs import files_read
from fe_models.progress import progress_bar
from fe_models.recordings import Dataset
from hybrid.config import Config, PresetName, configuration
from hybrid.notebook.data import Data, dataset_of

if TYPE_CHECKING:
    from hybrid.notebook.trained import TrainedModel


def train(
    data: Data,
    preset: PresetName = "default",
    *,
    out: str | Path | None = None,
    progress: bool | None = None,
    **options: Any,
) -> "TrainedModel":
    """Return a hybrid model trained on the recordings for training, scored on those for testing.

    ``data``: a dataset or its TOML file. ``preset``: "default"; "paper", Lai et al. 2022; "places", for chains;
    "experts", a model a recording. ``options`` are those of `ModelConfig` and `TrainingConfig`: ``epochs``, ``modes``,
    ``window``, ``seed``... ``out``: a folder for checkpoint, scores, prediction and curves; without one nothing is
    kept on disk. ``progress``: whether a bar is shown; None: where a terminal shows it. `InputError` with all that
    cannot be used, `TrainingDivergedError` where the training fails.
    """
    dataset = dataset_of(data, None)
    config = configuration(preset, getattr(dataset.model, "name", ""), options)
    if out is not None:
        from hybrid.training.run import results_in  # loads PyTorch, for this alone

        results_in(Path(out)).check(() if isinstance(data, Dataset) else files_read(Path(data)))
        return _trained(dataset, config, Path(out), progress, kept=True)
    with TemporaryDirectory() as folder:
        return _trained(dataset, config, Path(folder), progress, kept=False)


def _trained(dataset: Dataset, config: Config, folder: Path, progress: bool | None, kept: bool) -> "TrainedModel":
    from hybrid.notebook.trained import TrainedModel  # loads PyTorch, as all that follows does
    from hybrid.training.preparation import calibration_steps
    from hybrid.training.results import RESULT_STEPS, scored, write_results
    from hybrid.training.run import begin
    from hybrid.training.trainable import trainable

    dataset = trainable(dataset)
    with progress_bar("calibrating the linear part", calibration_steps(dataset, config), shown=progress) as bar:
        run = begin(dataset, config, folder, advance=bar.update)
    with progress_bar("training", config.training.epochs, "epoch", shown=progress) as bar:
        for _ in run.epochs():
            bar.update()
    with progress_bar("scoring", RESULT_STEPS if kept else 1, shown=progress) as bar:
        metrics = write_results(run, dataset, None, bar.update).metrics if kept else scored(run, dataset)[1]
    return TrainedModel(run.checkpoint(), metrics)
