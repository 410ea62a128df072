"""Which cases the certificate is of, and in which order they are done."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from benchmarks.blind.aims import Aims, aims_of
from benchmarks.blind.cases import CERTIFICATE_SEED, Task, default_words
from benchmarks.blind_cases import Acts, BlindConfig, Excitation, StructureName, Tier

CASES: dict[StructureName, int] = {"four_dof": 300, "bridge": 120}
"""How many of each column of free vibration: they bound a rate of 99 % to 97 to 100 %, and to 95 to 100 %."""
DRIVEN_CASES = 100  # of a column of a driven chain, which takes ten times as long: 95 % to 89 to 98 %
AMBIENT_CASES = 40  # of a column of ambient vibration, minutes each: 90 % to 77 to 96 %
FAR_CASES = 60  # of a column of bridges that are far from their drawing: 90 % to 80 to 95 %
LOST_CASES = 40  # of bridges that lost something before one recording: 100 % to 91 to 100 %
LOST = ("stiffness_change", "added_mass", "support_spring")
SEEDS = 100_000  # between the first seeds of two columns


@dataclass(frozen=True)
class Column:
    """``count`` cases of a ``structure``, its drawing as near to the truth as ``tier`` says; the seeds from
    ``first_seed`` on; ``excitation`` and ``acts``: see `BlindConfig`. What is hidden is one of ``kinds``, in turn;
    where none are given, all that such a case can hide.
    """

    structure: StructureName
    tier: Tier
    count: int
    first_seed: int
    excitation: Excitation = "free"
    acts: Acts = "all"
    kinds: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Structure, kind of nominal model, and what is unusual about the recordings."""
        parts = ["chain" if self.structure == "four_dof" else self.structure, self.tier]
        parts += [EXCITATION_WORDS[self.excitation]] if self.excitation != "free" else []
        return ", ".join(parts + ["in one recording"] * (self.acts == "one"))

    @property
    def config(self) -> BlindConfig:
        """What its cases are like."""
        return BlindConfig(structure=self.structure, tier=self.tier, excitation=self.excitation, acts=self.acts)

    @property
    def words(self) -> tuple[str, ...]:
        """What its cases hide, in turn."""
        return self.kinds or default_words(self.config)

    @property
    def aims(self) -> Aims:
        """What is to be reached."""
        return aims_of(self.tier, self.acts, self.excitation)

    @property
    def tasks(self) -> list[Task]:
        """Every kind equally often, to within one: in rounds of all, each in an order drawn from the first seed."""
        rng, words = np.random.default_rng(self.first_seed), self.words
        rounds = -(-self.count // len(words))
        hidden = [str(word) for _ in range(rounds) for word in rng.permutation(words)]
        return [Task(self.first_seed + number, hidden[number], self.config) for number in range(self.count)]


EXCITATION_WORDS: dict[Excitation, str] = {
    "free": "free vibration",
    "ambient": "ambient vibration",
    "measured": "known forces",
    "base": "base motion",
}
TIERS: tuple[Tier, ...] = ("exact", "off")
FREE = tuple(
    Column(structure, tier, count, CERTIFICATE_SEED + (2 * number + later) * SEEDS)
    for number, (structure, count) in enumerate(CASES.items())
    for later, tier in enumerate(TIERS)
)
COLUMNS = (
    *FREE,
    Column("bridge", "exact", AMBIENT_CASES, CERTIFICATE_SEED + 4 * SEEDS, "ambient", "one"),
    Column("bridge", "far", AMBIENT_CASES, CERTIFICATE_SEED + 5 * SEEDS, "ambient", "one"),
    Column("four_dof", "exact", DRIVEN_CASES, CERTIFICATE_SEED + 6 * SEEDS, "measured"),
    Column("four_dof", "exact", DRIVEN_CASES, CERTIFICATE_SEED + 7 * SEEDS, "base"),
    Column("bridge", "far", FAR_CASES, CERTIFICATE_SEED + 8 * SEEDS),
    Column("bridge", "far", FAR_CASES, CERTIFICATE_SEED + 9 * SEEDS, acts="one"),
    Column("bridge", "exact", LOST_CASES, CERTIFICATE_SEED + 10 * SEEDS, acts="one", kinds=LOST),
)


def interleaved(columns: Sequence[Column]) -> list[Task]:
    """Return all tasks, mixed so that the first of them have about the same share of each column."""
    placed = [((number + 0.5) / column.count, task) for column in columns for number, task in enumerate(column.tasks)]
    return [task for _, task in sorted(placed, key=lambda item: item[0])]
