"""How far the search goes: on a chain, whose fits take tenths of a second, and on a frame, where they take seconds."""

from dataclasses import dataclass

from hybrid.diagnosis.nominal.plant import Plant


@dataclass(frozen=True)
class Effort:
    """What is tried of a structure.

    ``helpless``: share of the misfit; where the best cause leaves more, a second one would only add to the guess.
    ``contests``: searches for a second cause, each on top of another first one.
    ``beside_law``: of the usual number of causes, the share that goes on after first steps beside a force law.
    ``thorough``: whether more is looked for beside causes that forecast well or leave next to nothing, and beside a
    change where a cause in all recordings does better alone; and recordings are sorted anew by force laws, too.
    """

    helpless: float
    contests: int
    beside_law: float
    thorough: bool


CHAIN = Effort(helpless=0.8, contests=3, beside_law=1.0, thorough=True)
FRAME = Effort(  # the first of two causes left up to 0.47 in 23 pairs hidden in a bridge; a contest takes a minute
    helpless=0.6, contests=1, beside_law=0.5, thorough=False
)


def effort_of(plant: Plant) -> Effort:
    """Return how far the search goes on the structure of a plant."""
    return CHAIN if plant.is_chain else FRAME
