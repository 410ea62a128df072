"""How far the search goes: on a chain, whose fits take tenths of a second, and on a frame, where they take seconds."""

from dataclasses import dataclass

from hybrid.diagnosis.nominal.nominal_model import NominalModel


@dataclass(frozen=True)
class Effort:
    """What is tried of a structure.

    ``contests``: searches for a second cause, each on top of another first one; on a frame one more, see `pair_fits`.
    ``beside_law``: of the usual number of causes, the share that goes on after first steps beside a force law.
    ``thorough``: whether more is looked for beside causes that forecast well, and beside a change where a cause in all
    recordings does better alone, or in one of two recordings where all forecast well; whether recordings are sorted
    anew by force laws, too; and whether a second cause may always replace the first, and single causes far behind the
    best are tried beside others.
    """

    contests: int
    beside_law: float
    thorough: bool


CHAIN = Effort(contests=3, beside_law=1.0, thorough=True)
FRAME = Effort(contests=2, beside_law=0.5, thorough=False)  # a contest takes half a minute


def effort_of(nominal: NominalModel) -> Effort:
    """Return how far the search goes on the structure of a nominal model."""
    return CHAIN if nominal.is_chain else FRAME
