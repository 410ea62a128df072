"""Show what recordings of free decays show by themselves, in one call."""

from typing import TYPE_CHECKING, overload

from fe_models.progress import progress_bar
from hybrid.notebook.data import Data, Design, dataset_of

if TYPE_CHECKING:
    from hybrid.notebook.compared_recordings import ComparedRecordings


@overload
def compare_recordings(design: Data, data: None = None, *, progress: bool | None = None) -> "ComparedRecordings": ...


@overload
def compare_recordings(design: Design, data: Data, *, progress: bool | None = None) -> "ComparedRecordings": ...


def compare_recordings(
    design: Design | Data, data: Data | None = None, *, progress: bool | None = None
) -> "ComparedRecordings":
    """Return the modes of each recording beside those of the ``design``, and how alike the recordings are.

    ``design``, ``data`` and ``progress`` as of `hybrid.diagnose`; a dataset alone is held against its own model.
    `InputError` with all that cannot be used.
    """
    dataset = dataset_of(design, data)
    from hybrid.identification.recording_comparison import compare_recordings as compare
    from hybrid.notebook.compared_recordings import ComparedRecordings

    motions = sum(len(recording.data) for recording in dataset.recordings)
    with progress_bar("modes of each motion", motions, "motion", shown=progress) as bar:
        return ComparedRecordings(compare(dataset, bar.update), dataset)
