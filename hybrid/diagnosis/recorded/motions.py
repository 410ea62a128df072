"""Motions by the names of their recordings: several in one file share its name."""

from collections import Counter

from fe_models.recordings import Dataset


def motions_of(dataset: Dataset) -> Counter[str]:
    """Return how many motions each recording holds, by its name, in the dataset's order."""
    return Counter(recording.name for recording in dataset.recordings for _ in recording.data)


def in_words(some: Counter[str], every: Counter[str]) -> str:
    """Return the names of ``some`` motions, and how many those are of a recording that holds more."""
    return ", ".join(
        name if count == every[name] else f"{count} of the {every[name]} motions of {name}"
        for name, count in some.items()
        if count
    )
