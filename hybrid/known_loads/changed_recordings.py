"""Recordings of a dataset that are taken otherwise than they were given, with a note that names them."""

from collections.abc import Callable
from dataclasses import replace

from fe_models.recordings import Dataset, Recording


def with_changed_recordings(
    dataset: Dataset, change: Callable[[Recording], Recording], note: str
) -> tuple[Dataset, list[str]]:
    """Return a dataset with each recording as ``change`` has it, and the ``note`` on the ``{names}`` of those that this
    does not return as they are; the dataset itself where there are none.
    """
    changed = tuple(change(recording) for recording in dataset.recordings)
    names = [old.name for old, new in zip(dataset.recordings, changed, strict=True) if new is not old]
    return (replace(dataset, recordings=changed), [note.format(names=", ".join(names))]) if names else (dataset, [])
