"""A trained hybrid model as a notebook has it: it prints its scores, is saved and read again."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fe_models.html import html_paragraph, html_table
from hybrid.estimation.experts import Hybrid
from hybrid.training.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from hybrid.training.run import CHECKPOINT, metrics_in
from hybrid.training.summary import describe

ROLES = {"measured": "measured channels", "held_out": "channels never fitted"}
MODELS = {"fe": "FE model", "hybrid": "hybrid"}


@dataclass(frozen=True, repr=False)
class TrainedModel:
    """What `hybrid.train` returns: the model with what it was made from, and its ``scores`` as plain data.

    ``scores``: NRMSE and R2 of forecasts of the test recordings by the FE model and the hybrid, as in ``metrics.json``;
    empty of a model that was read without them.
    """

    checkpoint: Checkpoint
    scores: dict[str, Any]

    @property
    def model(self) -> Hybrid:
        """The PyTorch module."""
        return self.checkpoint.model

    def save(self, path: str | Path) -> Path:
        """Write the model, without its scores, into a file that `hybrid.load_trained` reads; return its path."""
        save_checkpoint(self.checkpoint, Path(path))
        return Path(path)

    def __repr__(self) -> str:
        origin = self.checkpoint.origin
        sensors = ", ".join(sensor.name for sensor in origin.sensors)
        head = f"Hybrid model of {len(origin.modal.omega)} modes and the sensors {sensors}."
        return "\n".join([head, describe(self.scores)]) if self.scores else head

    def _repr_html_(self) -> str:
        found = self.scores.get("scores")
        if not found:
            return html_paragraph(repr(self))
        rows = [
            (words, *(f"{found[model][role][score]:.4g}" for model in MODELS for score in ("nrmse", "r2")))
            for role, words in ROLES.items()
            if found["fe"][role] is not None
        ]
        columns = [f"{score} of {words}" for words in MODELS.values() for score in ("NRMSE", "R2")]
        return html_table(("forecasts of the test recordings", *columns), rows)


def load_trained(path: str | Path) -> TrainedModel:
    """Return a model from its file, or from the folder of a training, then with its scores.

    `InputError` where there is none.
    """
    file = Path(path) / CHECKPOINT if Path(path).is_dir() else Path(path)
    return TrainedModel(load_checkpoint(file), metrics_in(file.parent) if file.name == CHECKPOINT else {})
