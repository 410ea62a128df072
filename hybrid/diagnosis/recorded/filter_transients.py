"""The ends of low-passed recordings: a filter that begins or stops amid a motion rings there, and no structure does.

A recording that starts at the release holds the filtered jump of the accelerations; what ran before its first sample,
the filter never saw. A fit takes such ringing for dampers and axial forces that act on fast modes.
"""

from dataclasses import replace
from math import ceil

from fe_models.files.recording_checks import MIN_SAMPLES
from fe_models.recordings import Dataset
from hybrid.diagnosis.recorded.config import FILTER_TRANSIENTS
from hybrid.known_loads.behind_lowpass import behind


def without_ringing_ends(dataset: Dataset) -> tuple[Dataset, list[str]]:
    """Return a dataset without the samples in which a low-pass may ring, and a note on them.

    Known loads pass it whole, before they are cut.
    """
    rate, lowpass = dataset.sampling_rate, dataset.lowpass
    if lowpass is None or lowpass >= rate / 2:
        return dataset, []
    wanted, recordings, left_out = ceil(FILTER_TRANSIENTS.ringing_periods * rate / lowpass), [], set[int]()
    for recording in dataset.recordings:
        samples = recording.data.shape[1]
        count = max(min(wanted, int(FILTER_TRANSIENTS.max_cut_share * samples), (samples - MIN_SAMPLES) // 2), 0)
        loads = tuple(replace(load, values=behind(load.values, rate, lowpass)) for load in recording.loads)
        base = tuple(replace(motion, values=behind(motion.values, rate, lowpass)) for motion in recording.base)
        recordings.append(replace(recording, loads=loads, base=base).part(count, samples - count))
        left_out.add(count)
    if left_out == {0}:
        return dataset, []
    counts = " to ".join(str(count) for count in sorted({min(left_out), max(left_out)}))
    note = f"a low-pass rings where a recording begins and ends: {counts} samples at each end are not used"
    return replace(dataset, recordings=tuple(recordings)), [note]
