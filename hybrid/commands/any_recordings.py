"""Recordings of whatever model as the options of `simulate` describe them."""

from collections.abc import Callable

from fe_models.linear import LinearModel
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.commands.matrix_recordings import matrix_recordings
from hybrid.commands.recording_options import RecordingOptions
from hybrid.commands.recordings import structure_recordings


def recordings_of(
    model: str, subject: Structure | LinearModel, given: RecordingOptions, seed: int
) -> Callable[[], Dataset]:
    """Check the options on recordings, all at once, and return the simulation that they ask for."""
    if isinstance(subject, LinearModel):
        return matrix_recordings(subject, given, seed)
    return structure_recordings(model, subject, given, seed)
