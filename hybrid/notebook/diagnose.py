"""Name what a simulation gets wrong, in one call."""

from typing import TYPE_CHECKING, overload

from fe_models.progress import stage_bar
from hybrid.diagnosis.stage_names import STAGE_NAMES
from hybrid.notebook.data import Data, Design, dataset_of

if TYPE_CHECKING:
    from hybrid.notebook.report import Report


@overload
def diagnose(design: Data, data: None = None, *, by_modes: bool = False, progress: bool | None = None) -> "Report": ...


@overload
def diagnose(design: Design, data: Data, *, by_modes: bool = False, progress: bool | None = None) -> "Report": ...


def diagnose(
    design: Design | Data, data: Data | None = None, *, by_modes: bool = False, progress: bool | None = None
) -> "Report":
    """Return what the simulation of a ``design`` gets wrong of ``data``: causes, ranked, or that nothing is wrong.

    ``design``: a structure, or what names one ("bridge", "frame.toml"); ``data``: a dataset or its TOML file. A dataset
    alone is held against its own model. ``by_modes``: go by natural frequencies, damping ratios, mode shapes and motion
    in any case, as for a structure that may be far from its drawing; else a first look decides. ``progress``: whether a
    bar is shown; None: where a terminal shows it. A chain takes seconds, a frame minutes. `InputError` with all that
    cannot be used.
    """
    dataset = dataset_of(design, data, dead_channels=True)  # before the search is loaded, which takes longer
    with stage_bar(STAGE_NAMES, progress) as begin:
        begin("loading")
        from hybrid.diagnosis.diagnosis import diagnose as by_what_a_look_says
        from hybrid.diagnosis.modes_and_motion.modal_diagnosis import diagnose_modes
        from hybrid.notebook.report import Report

        search = diagnose_modes if by_modes else by_what_a_look_says
        return Report(search(dataset, begin), dataset, by_modes)
