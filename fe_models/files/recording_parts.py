"""The recordings of a dataset file: their tables read, their files loaded, what is in them checked."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fe_models.errors import noting
from fe_models.files.dataset_parts import Channels, Surroundings, modes_alone
from fe_models.files.gaps import Mended, mended
from fe_models.files.known_motion import KNOWN_MOTION, Checked, excitation_faults, named_columns, read_known_motion
from fe_models.files.recording_checks import check_data, check_rates, size_faults
from fe_models.files.recording_files import RecordingFile, load_recording, skipped_note
from fe_models.files.tables import Table, at, read_list, read_table
from fe_models.quiet_start import quiet_start, quiet_words
from fe_models.recordings import Excitation, Recording


@dataclass(frozen=True)
class _RecordingTable:
    name: str
    file: str
    key: str | None = None
    role: Literal["train", "test"] = "train"
    sampling_rate: float | None = None
    excitation: Excitation | None = None


@dataclass(frozen=True)
class ReadRecordings:
    """The ``recordings`` that could be read, with data (realisation, time, sensor) and loads; ``notes`` on the rest."""

    recordings: tuple[Recording, ...]
    notes: tuple[str, ...]


def read_recordings(
    document: Table, where: str, surroundings: Surroundings, channels: Channels, faults: list[str]
) -> ReadRecordings:
    """Return the recordings that could be read, and what of their files was skipped."""
    recordings: list[Recording] = []
    forms: dict[str, list[str]] = {}  # the files of each form that is not one of commas alone
    skipped: dict[tuple[str, ...], list[str]] = {}  # the files that have the same columns that nobody asks for
    notes = list[str]()
    tables = read_list(document, "recordings", where, faults)
    load_columns = named_columns([table for _, table in tables])
    for place, table in tables:
        plain = (
            {key: value for key, value in table.items() if key not in KNOWN_MOTION}
            if isinstance(table, dict)
            else table
        )
        row = read_table(_RecordingTable, plain, place, faults)
        alone = _with_own_rate(row, place, surroundings, faults) if row else surroundings
        found = _read_file(row, place, alone, channels, load_columns, faults) if row else None
        samples = None if found is None else found.data.shape[1]
        checked = Checked(surroundings.folder, surroundings.dofs, surroundings.node_count, samples)
        loads, base = read_known_motion(table, place, checked, faults) if isinstance(table, dict) else ((), ())
        if row is not None and found is not None:
            own = None if row.sampling_rate == surroundings.sampling_rate else row.sampling_rate
            recording = Recording(row.name, found.data, row.role, loads, 0, base, own, row.excitation)
            done = _mended(recording, row, place, alone, channels, faults)
            recordings += done.stretches
            notes += [*done.notes, *_quiet_notes(done.stretches, alone.sampling_rate)]
            faults.extend(f"{place} ({row.name}): {fault}" for fault in excitation_faults(row.excitation, table))
            if found.skipped:
                skipped.setdefault(found.skipped, []).append(row.file)
            notes += [f"{row.file}: {note}" for note in found.notes]
            if found.form:
                forms.setdefault(found.form, []).append(row.file)
    roles = [table.get("role", "train") for _, table in tables if isinstance(table, dict)]
    if "train" not in roles and not modes_alone(document):
        faults.append(f'{at(where, "recordings")}: none has the role "train"; at least one is needed to learn from')
    names = Counter(str(table.get("name")) for _, table in tables if isinstance(table, dict) and "name" in table)
    for name, times in names.items():
        if times > 1:
            faults.append(f"{at(where, 'recordings')}: name {name!r} is used {times} times")
    notes += [f"{', '.join(dict.fromkeys(files))}: read as a file {form}" for form, files in forms.items()]
    notes += [skipped_note(columns, dict.fromkeys(files)) for columns, files in skipped.items()]
    return ReadRecordings(tuple(recordings), tuple(notes))


def _quiet_notes(recordings: Sequence[Recording], rate: float | None) -> list[str]:
    """Return a note on each recording that is to be free and in whose beginning nothing moves; ``rate``: in Hz."""
    notes = []
    for recording in recordings:
        if rate is None or recording.is_driven or recording.excitation not in (None, "free"):
            continue
        quiet = min(map(quiet_start, recording.data), default=0)
        if quiet:
            notes.append(f"{recording.name}: {quiet_words(quiet / rate)}")
    return notes


def _with_own_rate(row: _RecordingTable, place: str, surroundings: Surroundings, faults: list[str]) -> Surroundings:
    """Return what a recording is checked against, with its own sampling rate where it states one."""
    if row.sampling_rate is None:
        return surroundings
    found = check_rates(row.sampling_rate, surroundings.lowpass)
    faults.extend(f"{place} ({row.name}): {fault}" for fault in found)
    if found:
        return replace(surroundings, sampling_rate=None, lowpass=None)
    return replace(surroundings, sampling_rate=row.sampling_rate)


def _read_file(
    row: _RecordingTable,
    place: str,
    surroundings: Surroundings,
    channels: Channels,
    load_columns: set[tuple[str, str]],
    faults: list[str],
) -> RecordingFile | None:
    where = f"{place} ({row.name})"
    path, rate = surroundings.folder / row.file, surroundings.sampling_rate
    loads = {key for file, key in load_columns if file == row.file}
    found = noting(faults, where, load_recording, path, row.key, channels.names, rate, loads, channels.units)
    if found is None:
        return None
    with np.errstate(invalid="ignore", over="ignore"):  # what is not finite is named below
        data = found.data * channels.factors
    names = [f"{where}: {row.file}: channel {name!r}" for name in channels.names]
    wrong = size_faults(data, names)
    faults.extend(wrong)
    return None if wrong else replace(found, data=data)


def _mended(
    recording: Recording,
    row: _RecordingTable,
    place: str,
    surroundings: Surroundings,
    channels: Channels,
    faults: list[str],
) -> Mended:
    """Return the recording without lost samples, noting what is wrong with any of its stretches."""
    if {len(values) for values in recording.driving} - {recording.data.shape[1]}:
        return Mended((recording,))  # a fault that is known already
    found = noting(faults, f"{place} ({row.name}): {row.file}", mended, recording, channels.names)
    if found is None:
        return Mended(())
    rate, lowpass = surroundings.sampling_rate, surroundings.lowpass
    for stretch in found.stretches:
        wrong = check_data(stretch.data, channels.names, rate, lowpass, surroundings.dead_channels)
        faults.extend(f"{place} ({stretch.name}): {row.file}: {fault}" for fault in wrong)
    return found
