"""The hybrid model: a Neural Modal ODE learned from sparse measurements on top of a finite element model's modes.

What a notebook needs stands here (`docs/api.md`), and is loaded when it is asked for.

::

    import fe_models as fe, hybrid

    report = hybrid.diagnose(fe.four_dof(), "recordings/dataset.toml")
    print(report)
"""

from typing import TYPE_CHECKING

from fe_models.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from hybrid.notebook.compare import compare_recordings as compare_recordings
    from hybrid.notebook.compared_recordings import ComparedRecordings as ComparedRecordings
    from hybrid.notebook.diagnose import diagnose as diagnose
    from hybrid.notebook.predict import predict as predict
    from hybrid.notebook.predicted_field import PredictedField as PredictedField
    from hybrid.notebook.report import Report as Report
    from hybrid.notebook.train import train as train
    from hybrid.notebook.trained import TrainedModel as TrainedModel
    from hybrid.notebook.trained import load_trained as load_trained

_HOMES = {
    "hybrid.notebook.diagnose": ("diagnose",),
    "hybrid.notebook.report": ("Report",),
    "hybrid.notebook.train": ("train",),
    "hybrid.notebook.trained": ("TrainedModel", "load_trained"),
    "hybrid.notebook.predict": ("predict",),
    "hybrid.notebook.predicted_field": ("PredictedField",),
    "hybrid.notebook.compare": ("compare_recordings",),
    "hybrid.notebook.compared_recordings": ("ComparedRecordings",),
}
__all__ = [name for names in _HOMES.values() for name in names]
if not TYPE_CHECKING:  # so that a type checker knows these names alone
    __getattr__, __dir__ = lazy_exports(__name__, _HOMES)
