"""A training as a person at a terminal sees it: what goes on, how far it is, and what to do when it stops."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import torch

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.progress import progress_bar
from fe_models.recordings import Dataset
from hybrid.config import Config
from hybrid.training.gradient_training import TrainingDivergedError
from hybrid.training.preparation import calibration_steps
from hybrid.training.results import RESULT_STEPS, Results, write_results
from hybrid.training.run import PARTIAL_CHECKPOINT, Run, begin, resume
from hybrid.training.summary import window_notes

INTERRUPTED_STATUS = 130  # as shells report Ctrl-C
DIVERGED_STATUS = 1


def open_run(data: Dataset, config: Config, out: Path, device: str, fresh: bool = False) -> Run:
    """Go on with the training that was interrupted in ``out``, or begin a new one."""
    if (out / PARTIAL_CHECKPOINT).exists() and not fresh:
        run = resume(data, config, out, device)
        print(f"Going on with the training interrupted after epoch {len(run.history)} (--fresh starts anew).")
        return run
    with progress_bar("Calibrating the linear part", calibration_steps(data, config), "step") as bar:
        run = begin(data, config, out, device, bar.update)
    if run.moved is not None:
        print(f"Note: {PARTIAL_CHECKPOINT} was damaged; it is now {run.moved.name}, and may be removed.")
    for name in run.origin.left_out:
        print(f"Recording {name} contradicts the other training recordings: it is left out.")
    windows, samples = run.trainer.windows.shape[:2]
    of_each = windows // len(run.origin.kept) if config.model.experts else windows
    for note in window_notes(of_each, samples, len(run.origin.modal.omega), config):
        print(f"Note: {note}.")
    return run


def train(run: Run, words: str = "Training") -> None:
    """Train to the end under a progress bar; an interruption or a divergence ends the program with what to do."""
    bar = progress_bar(words, run.config.training.epochs, "epoch", done=len(run.history))
    try:
        with divergence_exits(), bar:
            for result in run.epochs():
                bar.set_postfix_str(f"loss {result.loss / result.horizon:.3f}, horizon {result.horizon}")
                bar.update()
    except KeyboardInterrupt:
        print(f"Interrupted after epoch {len(run.history)}; the same command goes on from there.", file=sys.stderr)
        raise SystemExit(INTERRUPTED_STATUS) from None


def score(run: Run, data: Dataset, truth: FloatArray | None = None) -> Results:
    """Score the trained model, write all results (`results.write_results`) under a progress bar; return them."""
    with progress_bar("Scoring and drawing curves", RESULT_STEPS, "step") as bar, divergence_exits():
        return write_results(run, data, truth, bar.update)


def check_device(device: str) -> None:
    """Raise `InputError` where PyTorch has no such device here."""
    try:
        if torch.device(device).type not in ("cpu", "cuda"):
            raise InputError(f"--device {device} is not supported; use cpu or cuda")
        torch.zeros(1, device=device)
    except (RuntimeError, AssertionError) as error:
        reason = str(error).splitlines()[0]
        raise InputError(f"--device {device} cannot be used here ({reason}); use --device cpu") from None


@contextmanager
def divergence_exits() -> Iterator[None]:
    """Turn a `TrainingDivergedError` inside the block into one line on stderr and an exit status."""
    try:
        yield
    except TrainingDivergedError as error:
        print(f"error: {error}", file=sys.stderr)
        raise SystemExit(DIVERGED_STATUS) from None
