"""Claims about a structure: which causes act in it, in which recordings."""

from collections.abc import Sequence
from dataclasses import dataclass

from hybrid.diagnosis.response.hypothesis import Hypothesis


@dataclass(frozen=True)
class Claim:
    """What is wrong: the candidates of a ``hypothesis``, each in the recordings (numbers) of ``acts``; ``changed``:
    those whose structure has changed in an unknown way.
    """

    hypothesis: Hypothesis
    acts: tuple[tuple[int, ...], ...] = ()
    changed: tuple[int, ...] = ()

    def idle_in(self, recording: int) -> tuple[int, ...]:
        """Return the numbers of the candidates that act in other recordings alone."""
        return tuple(number for number, acts in enumerate(self.acts) if recording not in acts)

    def less(self, number: int) -> "Claim":
        """Return the claim without one of its candidates."""
        acts = tuple(own for position, own in enumerate(self.acts) if position != number)
        return Claim(self.hypothesis.less((number,)), acts, self.changed)

    def within(self, recordings: Sequence[int]) -> tuple["Claim", tuple[int, ...]]:
        """Return the claim about some ``recordings`` alone, numbered anew, and the numbers of the candidates that act
        in none of them.
        """
        idle = tuple(number for number, acts in enumerate(self.acts) if not set(acts) & set(recordings))
        kept = [acts for number, acts in enumerate(self.acts) if number not in idle]
        acts = tuple(_numbered_anew(own, recordings) for own in kept)
        return Claim(self.hypothesis.less(idle), acts, _numbered_anew(self.changed, recordings)), idle

    def differs_among(self, recordings: int) -> bool:
        """Return whether some of so many ``recordings`` are of another structure than others."""
        return any(0 < len(set(acts)) < recordings for acts in (*self.acts, self.changed))

    @property
    def key(self) -> tuple[object, ...]:
        """What two equal claims have in common."""
        named = zip(self.hypothesis.candidates, self.acts, strict=True)
        return tuple(sorted((candidate.key, acts) for candidate, acts in named)), self.changed


def _numbered_anew(some: tuple[int, ...], recordings: Sequence[int]) -> tuple[int, ...]:
    """Return ``some`` recordings by where they stand among ``recordings``, without those that are none of these."""
    return tuple(new for new, old in enumerate(recordings) if old in some)
