"""Whether recordings are of one structure, in one state: the first thing that a comparison says.

Of ambient recordings chance decides, of free decays how far the modes of one explain the other: amplitude and
temperature move their frequencies by more than chance does.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.identification.agreement import largest_agreeing_group
from hybrid.identification.config import AGREEMENT
from hybrid.identification.mode_changes import RecordingChange, states_among
from hybrid.identification.recording_comparison import Compared


class Outcome(Enum):
    """Whether recordings are of one structure in one state."""

    ONE = "one state"
    SEVERAL = "several states"
    OPEN = "cannot be told"


@dataclass(frozen=True)
class StructureStates:
    """The ``outcome``, and the ``sentence`` that says it."""

    outcome: Outcome
    sentence: str


def structure_states(compared: Compared) -> StructureStates:
    """Return whether what was ``compared`` is of one structure in one state."""
    names = [observed.name for observed in compared.recordings]
    return states(names, compared.changes) if compared.has_ambient else one_structure(names, compared.left)


def states(names: list[str], changes: Sequence[RecordingChange]) -> StructureStates:
    """Return which recordings of these ``names`` are of one state of the structure, by chance."""
    if len(names) < 2:
        return StructureStates(Outcome.ONE, "There is one recording: whether the structure changed cannot be asked.")
    found = states_among(changes, len(names))
    if len(found) == 1:
        same = "Between the recordings nothing changed beyond chance: the frequencies of their modes agree."
        return StructureStates(Outcome.ONE, same)
    pairs = [[names[number] for number in change.recordings] for change in changes if change.chance is None]
    unlike = f"no mode is seen in both of {'; '.join(' and '.join(pair) for pair in pairs)}"
    if not any(change.is_plain for change in changes):
        return StructureStates(Outcome.OPEN, f"Whether the structure changed between the recordings is open: {unlike}.")
    told = "; ".join(", ".join(names[number] for number in own) for own in found)
    changed = f"The structure changed between the recordings, beyond chance: {told} are states of their own"
    return StructureStates(Outcome.SEVERAL, f"{changed} ({unlike})." if pairs else f"{changed}.")


def one_structure(names: list[str], left: FloatArray) -> StructureStates:
    """Return whether recordings of these ``names`` are of one structure.

    ``left`` (model, recording): the share of a recording's energy that the modes of each leave.
    """
    if len(names) < 2:
        alone = "There is one recording: whether several are of one structure cannot be asked."
        return StructureStates(Outcome.ONE, alone)
    untold = "Whether the recordings are of one structure cannot be told"
    most = AGREEMENT.max_unexplained_share
    unclear = [name for name, own in zip(names, np.diag(left), strict=True) if own >= most]
    if unclear:
        found = f"the modes found in {', '.join(unclear)} leave more than {most:.0%} of its own energy"
        return StructureStates(Outcome.OPEN, f"{untold}: {found}.")
    group = largest_agreeing_group(left)
    if len(group) == len(names):
        least = np.floor(1000 * (1 - left[np.ix_(group, group)].max())) / 1000
        return StructureStates(
            Outcome.ONE,
            f"The recordings are of one structure: the modes of each explain {least:.1%} of another's energy or more.",
        )
    agreeing, odd = [names[n] for n in group], [name for n, name in enumerate(names) if n not in group]
    does = "does" if len(odd) == 1 else "do"
    known = f"{', '.join(agreeing)} agree, {', '.join(odd)} {does} not" if len(group) > 1 else "no two agree"
    return StructureStates(
        Outcome.SEVERAL,
        f"The recordings are not all of one structure: {known} (the modes of one leave more than {most:.0%} of the"
        " other's energy).",
    )
