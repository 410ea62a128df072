"""Show what recordings show by themselves, in one call."""

from pathlib import Path
from typing import TYPE_CHECKING, overload

from fe_models.files.models import load_model
from hybrid.notebook.data import Data, Design, dataset_of

if TYPE_CHECKING:
    from hybrid.notebook.compared_recordings import ComparedRecordings


@overload
def compare_recordings(
    design: Data, data: None = None, *, extended: Design | None = None, progress: bool | None = None
) -> "ComparedRecordings": ...


@overload
def compare_recordings(
    design: Design, data: Data, *, extended: Design | None = None, progress: bool | None = None
) -> "ComparedRecordings": ...


def compare_recordings(
    design: Design | Data, data: Data | None = None, *, extended: Design | None = None, progress: bool | None = None
) -> "ComparedRecordings":
    """Return the modes of each recording beside those of the ``design``, and how alike the recordings are; of those
    under known forces the frequency response functions beside the design's, and those of an ``extended`` model.

    ``design``, ``data`` and ``progress`` as of `hybrid.diagnose`; a dataset alone is held against its own model.
    `InputError` with all that cannot be used.
    """
    dataset = dataset_of(design, data)
    beside = load_model(str(extended)) if isinstance(extended, str | Path) else extended
    from hybrid.identification.dataset_comparison import compare_dataset
    from hybrid.notebook.compared_recordings import ComparedRecordings

    return ComparedRecordings(compare_dataset(dataset, beside, progress))
