"""Name what a simulation gets wrong, in one call."""

from typing import TYPE_CHECKING, overload

from fe_models.progress import stage_bar
from hybrid.diagnosis.stage_names import STAGE_NAMES
from hybrid.notebook.data import Data, Design, dataset_of

if TYPE_CHECKING:
    from hybrid.notebook.report import Report


@overload
def diagnose(design: Data, data: None = None, *, progress: bool | None = None) -> "Report": ...


@overload
def diagnose(design: Design, data: Data, *, progress: bool | None = None) -> "Report": ...


def diagnose(design: Design | Data, data: Data | None = None, *, progress: bool | None = None) -> "Report":
    """Return what the simulation of a ``design`` gets wrong of ``data``: causes, ranked, or that nothing is wrong.

    ``design``: a structure, or what names one ("bridge", "frame.toml"); ``data``: a dataset or its TOML file. A dataset
    alone is held against its own model. ``progress``: whether a bar is shown; None: where a terminal shows it. A
    chain takes seconds, a frame minutes. `InputError` with all that cannot be used.
    """
    dataset = dataset_of(design, data, dead_channels=True)  # before the search is loaded, which takes longer
    with stage_bar(STAGE_NAMES, progress) as begin:
        begin("loading")
        from hybrid.diagnosis.diagnosis import diagnose as search
        from hybrid.notebook.report import Report

        return Report(search(dataset, begin), dataset)
