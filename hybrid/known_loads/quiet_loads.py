"""What load cells show at rest, beside blows: noise and an offset, which would move the model and not the structure.

As the force window of impact testing does, forces are taken as zero where nothing but noise is recorded.
"""

from dataclasses import replace

import numpy as np
from scipy.ndimage import binary_dilation
from scipy.stats import median_abs_deviation

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset, Recording
from hybrid.known_loads.changed_recordings import with_changed_recordings
from hybrid.known_loads.config import QUIET_LOADS

NOTE = "beside their blows the forces of {names} are noise of the load cell: there they count as zero"


def with_quiet_loads(dataset: Dataset) -> tuple[Dataset, list[str]]:
    """Return a dataset whose loads are zero where their load cells are at rest, and a note on those that were not."""
    return with_changed_recordings(dataset, _quiet, NOTE)


def _quiet(recording: Recording) -> Recording:
    """Return a recording with its loads at rest as zero; the recording itself where they are, or are never at rest."""
    loads = tuple(replace(load, values=at_rest_as_zero(load.values)) for load in recording.loads)
    same = all(new.values is old.values for new, old in zip(loads, recording.loads, strict=True))
    return recording if same else replace(recording, loads=loads)


def at_rest_as_zero(values: FloatArray) -> FloatArray:
    """Return a load's ``values`` (time,) less their offset, zero where nothing but noise stands out of that.

    The values themselves where a load is not at rest most of the time, or has no noise there: blows are few and strong,
    a sweep or a random force never is at rest.
    """
    offset = float(np.median(values))
    noise = float(median_abs_deviation(values, scale="normal"))
    size = np.abs(values - offset)
    acting, largest = size > QUIET_LOADS.min_acting_sigma * noise, float(size.max(initial=0.0))
    is_noise = QUIET_LOADS.min_noise_share * largest < noise < largest / QUIET_LOADS.min_blow_sigma
    if not is_noise or acting.mean() > QUIET_LOADS.max_acting_share:
        return values
    near = binary_dilation(acting, iterations=QUIET_LOADS.samples_beside)
    return np.where(near, values - offset, 0.0)
