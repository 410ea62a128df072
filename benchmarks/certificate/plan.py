"""Which cases the certificate is of, and in which order they are done."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from benchmarks.blind.cases import CERTIFICATE_SEED, Task, words_of
from benchmarks.blind_cases import BlindConfig
from benchmarks.blind_cases.case import Tier

StructureName = Literal["four_dof", "bridge"]
CASES: dict[StructureName, int] = {"four_dof": 300, "bridge": 120}
"""How many of each column: they bound a rate of 99 % to 97 to 100 %, and to 95 to 100 %."""
SEEDS = 100_000  # between the first seeds of two columns


@dataclass(frozen=True)
class Column:
    """``count`` cases of a ``structure``, exact or ``off`` by its uncertainty; the seeds from ``first_seed`` on."""

    structure: StructureName
    off: bool
    count: int
    first_seed: int

    @property
    def name(self) -> str:
        """Structure and kind of nominal model."""
        return f"{'chain' if self.structure == 'four_dof' else self.structure}, {self.tier}"

    @property
    def tier(self) -> Tier:
        """How near the nominal models are."""
        return "off" if self.off else "exact"

    @property
    def tasks(self) -> list[Task]:
        """Every kind equally often, to within one: in rounds of all, each in an order drawn from the first seed."""
        rng, words = np.random.default_rng(self.first_seed), words_of(self.structure)
        rounds = -(-self.count // len(words))
        hidden = [str(word) for _ in range(rounds) for word in rng.permutation(words)]
        config = BlindConfig(structure=self.structure, tier=self.tier)
        return [Task(self.first_seed + number, hidden[number], config) for number in range(self.count)]


COLUMNS = tuple(
    Column(structure, off, count, CERTIFICATE_SEED + (2 * number + off) * SEEDS)
    for number, (structure, count) in enumerate(CASES.items())
    for off in (False, True)
)


def interleaved(columns: Sequence[Column]) -> list[Task]:
    """Return all tasks, mixed so that the first of them have about the same share of each column."""
    placed = [((number + 0.5) / column.count, task) for column in columns for number, task in enumerate(column.tasks)]
    return [task for _, task in sorted(placed, key=lambda item: item[0])]
