"""What a simulation assumes and the diagnosis does not follow is reported."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.built_in.four_dof import four_dof
from fe_models.recordings import Assumptions, Dataset, Recording, Sensor
from hybrid.diagnosis.nominal.ignored_assumptions import ignored_assumptions
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from tests.masts import masts, recorded


def test_modes_of_a_chain_beyond_its_low_pass_are_not_asked_for() -> None:
    sensor = Sensor("x1", 1, "x", "displacement", "m")
    data = np.random.default_rng(0).standard_normal((1, 300, 1))
    for lowpass, reported in ((None, 1), (0.25, 0)):
        given = Dataset(four_dof(), 10.0, (sensor,), (Recording("r", data),), lowpass, Assumptions(modes=2))
        assert len(ignored_assumptions(nominal_model_of(given), given.assumptions)) == reported


@pytest.mark.slow
@pytest.mark.parametrize(
    ("assumptions", "reported"),
    [
        (Assumptions(), []),
        (Assumptions(modes=4), []),
        (Assumptions(modes=3), ["keeps 3 modes, and the recordings can show 4"]),
        (Assumptions(integrator="newmark", step=0.01), []),
        (Assumptions(modes=1, integrator="newmark"), ["keeps 1 modes", '"newmark" has no step']),
    ],
)
def test_what_is_not_followed_is_reported(assumptions: Assumptions, reported: list[str]) -> None:
    dataset = recorded(masts())
    nominal = nominal_model_of(replace(dataset, assumptions=assumptions))
    notes = ignored_assumptions(nominal, assumptions)
    assert len(notes) == len(reported)
    assert all(words in note for words, note in zip(reported, notes, strict=True))
