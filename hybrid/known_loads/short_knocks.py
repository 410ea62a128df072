"""Knocks too short for their samples to tell their force: what comes after is a free decay, and is taken as one.

Half a sine of five samples has an impulse that these tell to 1 %, of three to 2 %: more than many a cause changes a
recording. What moves afterwards does not depend on it. Where a low-pass has widened what sensors show of it, its
ringing is left out with that of other beginnings (`filter_transients`).
"""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from fe_models.recordings import Dataset, Recording
from fe_models.spectra import line_frequencies
from hybrid.known_loads.changed_recordings import with_changed_recordings
from hybrid.known_loads.config import SHORT_KNOCKS

NOTE = (
    "the knocks of {names} are too short for their samples to tell their force: what comes after them is taken as free"
    " decay; a faster sampling, or an anti-aliasing filter, would tell it"
)


def without_short_knocks(dataset: Dataset) -> tuple[Dataset, list[str]]:
    """Return a dataset whose recordings of such knocks begin when these are over, without loads, and a note on them."""
    return with_changed_recordings(dataset, after_short_knock, NOTE)


def after_short_knock(recording: Recording) -> Recording:
    """Return what comes after a recording's knock, without loads; the recording itself where it is no such knock."""
    strong = _strong(recording)
    if not len(strong) or int(strong[-1]) + 1 - int(strong[0]) > SHORT_KNOCKS.max_samples:
        return recording
    return after_loads(recording) if any(_is_unresolved(load.values) for load in recording.loads) else recording


def after_loads(recording: Recording) -> Recording:
    """Return what comes after a recording's loads, without these; the recording itself where that is too little."""
    strong = _strong(recording)
    if not len(strong):
        return recording
    end, samples = int(strong[-1]) + SHORT_KNOCKS.samples_after, recording.data.shape[1]
    too_little = samples - end < SHORT_KNOCKS.min_share_left * samples
    return recording if too_little else replace(recording.part(end), loads=())


def _strong(recording: Recording) -> IntArray:
    """Return the samples (sample,) at which loads act, none where there are none, or the base moves."""
    if recording.base or not recording.loads:
        return np.zeros(0, dtype=int)
    force = np.sum([np.abs(load.values) for load in recording.loads], axis=0)
    if not force.any():
        return np.zeros(0, dtype=int)
    return np.flatnonzero(force > SHORT_KNOCKS.min_force_share * force.max())


def _is_unresolved(values: FloatArray) -> bool:
    """Return whether the power of a load is not gone at half the sampling rate: more of it was folded down."""
    power = np.abs(np.fft.rfft(values)) ** 2
    share = 2 * line_frequencies(len(values), 1.0)  # of half the rate
    top = power[share > SHORT_KNOCKS.top_band].mean()
    return bool(top > SHORT_KNOCKS.max_top_power * power[share < 1 - SHORT_KNOCKS.top_band].mean())
