"""What geometric forces add to a motion, against Exudyn: forces on a chain that a cubic spring exerts as well."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.blind import SENSORS
from fe_models.dofs import FloatArray
from fe_models.effects import CubicSpring, Effect
from fe_models.four_dof import four_dof
from fe_models.measurement import lowpassed
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.fitting.geometry_response import added
from hybrid.diagnosis.nominal.geometry import Geometry
from hybrid.diagnosis.nominal.plant import plant_of
from hybrid.diagnosis.recorded.records import batches_of
from hybrid.diagnosis.response.hypothesis import Hypothesis
from tests.test_diagnosis_loads import RATE, READOUT, SAMPLES, START, Waves, chain_motion, load_of, waves

STIFFNESS = 0.004  # N/m^3
GEOMETRY = Geometry(np.eye(4)[:, [2]], np.ones(1), np.array([[3]]), np.array([[-STIFFNESS]]), np.zeros((1, 4)))
SPRING = CubicSpring((3,), "x", STIFFNESS)  # exerts the same


LAWS = {"linear": (), "stiff": (CubicSpring((1,), "x", 0.5),), "soft": (CubicSpring((1,), "x", -0.02),)}


def difference(laws: tuple[Effect, ...], pushed: Waves = ()) -> FloatArray:
    """Return what Exudyn shows with the spring less what it shows without, (time, sensor)."""
    with_it, without = (chain_motion(pushed, START, *effects) for effects in ((*laws, SPRING), laws))
    return (with_it - without)[:, :4]


def told(laws: tuple[Effect, ...], pushed: Waves = (), lowpass: float | None = None) -> FloatArray:
    """Return what geometry that exerts the same adds, likewise."""
    recording = Recording("r", np.zeros((1, SAMPLES, len(SENSORS))), loads=(load_of(pushed),) if pushed else ())
    dataset = Dataset(four_dof().with_effects(*laws), RATE, SENSORS, (recording,), lowpass)
    (batch,) = batches_of(dataset, "train")
    hypothesis = Hypothesis(replace(plant_of(dataset), geometry=GEOMETRY))
    return added(hypothesis, hypothesis.centre, START.reshape(1, -1), batch, READOUT)[0]


@pytest.mark.parametrize("pushed", [(), waves(1, node=3)], ids=["free", "loaded"])
@pytest.mark.parametrize("laws", LAWS.values(), ids=LAWS)
def test_geometry_adds_what_a_spring_that_exerts_the_same_does(laws: tuple[Effect, ...], pushed: Waves) -> None:
    """Beside force laws, which answer to it, and under known loads."""
    expected = difference(laws, pushed)
    # Of some 8 % by which forces along the motion without them are off each round more leaves a tenth.
    assert np.abs(told(laws, pushed) - expected).max(axis=0) == pytest.approx(0, abs=2e-3 * np.abs(expected).max())


@pytest.mark.parametrize("laws", LAWS.values(), ids=LAWS)
def test_what_it_adds_passes_the_low_pass_of_the_recordings(laws: tuple[Effect, ...]) -> None:
    found, whole = told(laws, lowpass=0.3), told(laws)
    inside = slice(100, -100)  # as far as the filter reaches
    expected = lowpassed(whole, RATE, 0.3)[inside]
    size = np.abs(expected).max(axis=0)
    assert (np.abs(found[inside] - expected).max(axis=0) < 1e-2 * size).all()
    assert (np.abs(whole[inside] - expected).max(axis=0) > 0.1 * size).any()  # it takes something away


def test_a_motion_that_explodes_has_nothing_added() -> None:
    assert not told((CubicSpring((1,), "x", -0.5),)).any()
