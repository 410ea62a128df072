"""What a simulation assumes and the diagnosis does not follow is told."""

from dataclasses import replace

import pytest

from fe_models.recordings import Assumptions
from hybrid.diagnosis.nominal.not_followed import not_followed
from hybrid.diagnosis.nominal.plant import plant_of
from tests.masts import masts, recorded


@pytest.mark.parametrize(
    ("assumptions", "told"),
    [
        (Assumptions(), []),
        (Assumptions(modes=4), []),
        (Assumptions(modes=3), ["keeps 3 modes, and the recordings can show 4"]),
        (Assumptions(integrator="newmark", step=0.01), []),
        (Assumptions(modes=1, integrator="newmark"), ["keeps 1 modes", '"newmark" has no step']),
    ],
)
def test_what_is_not_followed_is_told(assumptions: Assumptions, told: list[str]) -> None:
    dataset = recorded(masts())
    plant = plant_of(replace(dataset, assumptions=assumptions))
    notes = not_followed(plant, assumptions)
    assert len(notes) == len(told)
    assert all(words in note for words, note in zip(told, notes, strict=True))
