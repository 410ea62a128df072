"""What is kept of each recording that was looked at, in one file that is written whole."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np
from pydantic import TypeAdapter, ValidationError

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.files.atomic import write_json

STATE_FILE = "watch.json"


class Standing(Enum):
    """How a recording stands to the history; the value is what a table says."""

    HISTORY = "history"
    USUAL = "as usual"
    ALARM = "alarm"
    UNREADABLE = "not readable"


@dataclass(frozen=True)
class SeenMode:
    """A mode of a recording: natural ``frequency`` (Hz), damping ``ratio``, both with standard deviations, its share of
    the ``energy``, and its real ``shape`` (sensor,) of displacements.
    """

    frequency: float
    frequency_error: float
    ratio: float
    ratio_error: float
    energy: float
    shape: tuple[float, ...]


@dataclass(frozen=True)
class Limits:
    """Control limits of a mode in a recording, Hz; ``mode``: its number among the tracked ones; ``found``: its
    frequency in the recording, None where it is not seen.
    """

    mode: int
    low: float
    centre: float
    high: float
    found: float | None


@dataclass(frozen=True)
class Observation:
    """A recording by its ``name``, its ``file``, relative to the folder that is watched if in it, and when that was
    written last (``modified``, ns); ``state``: the number of the structure's state, whose history it is held against;
    its ``standing`` and ``modes``.

    ``distance``: T^2 over its control limit, None of what was not judged; ``limits`` of each tracked mode; ``words``:
    what is unusual, or why it could not be read; ``diagnosis``: the folder, within the results, of the diagnosis of the
    change, "" where there is none.
    """

    name: str
    file: str
    modified: int
    state: int
    standing: Standing
    modes: tuple[SeenMode, ...] = ()
    distance: float | None = None
    limits: tuple[Limits, ...] = ()
    words: tuple[str, ...] = ()
    diagnosis: str = ""

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies (mode,), Hz."""
        return np.array([mode.frequency for mode in self.modes], dtype=float)

    @property
    def shapes(self) -> FloatArray:
        """Shapes (sensor, mode)."""
        return np.array([mode.shape for mode in self.modes], dtype=float).T


@dataclass(frozen=True)
class Kept:
    """All ``observations`` of a station, in the order in which they came; ``digests``: of what they were read by."""

    digests: dict[str, str]
    observations: tuple[Observation, ...] = ()

    @property
    def state(self) -> int:
        """The number of the state that recordings are held against now."""
        return max((own.state for own in self.observations), default=1)

    @property
    def history(self) -> tuple[Observation, ...]:
        """The recordings of the structure as it usually is now."""
        return tuple(
            own
            for own in self.observations
            if own.state == self.state and own.standing in (Standing.HISTORY, Standing.USUAL)
        )


def alarms_at_the_end(observations: Sequence[Observation]) -> list[int]:
    """Return the numbers of the last recordings without one that is as usual among or after them."""
    found = list[int]()
    for number in reversed(range(len(observations))):
        standing = observations[number].standing
        if standing is Standing.ALARM:
            found.append(number)
        elif standing is not Standing.UNREADABLE:
            break
    return found[::-1]


def load_kept(folder: Path, digests: dict[str, str]) -> Kept:
    """Return what was kept in ``folder``, nothing where it is new; `InputError` where that is of another station.

    ``digests``: of what recordings are read by, each by its name.
    """
    path = folder / STATE_FILE
    try:
        text = path.read_bytes()
    except FileNotFoundError:
        return Kept(digests)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    try:
        kept = TypeAdapter(Kept).validate_json(text)
    except ValidationError as error:
        raise InputError(f"{path}: is no history that this version reads; give another --out, or remove it") from error
    changed = [name for name in digests if kept.digests.get(name) != digests[name]]
    if changed:
        raise InputError(
            f"{path}: is a history that began with another {' and another '.join(changed)}; give another --out, or"
            " remove it to begin anew"
        )
    return kept


def save_kept(folder: Path, kept: Kept) -> None:
    """Write all that is kept."""
    content = TypeAdapter(Kept).dump_python(kept, mode="json")
    write_json(folder / STATE_FILE, {"schema": 1, **content})


def with_last(kept: Kept, last: Observation) -> Kept:
    """Return what is kept with one more observation."""
    return Kept(kept.digests, (*kept.observations, last))
