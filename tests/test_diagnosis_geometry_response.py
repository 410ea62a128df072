"""What geometric forces add to a motion, against Exudyn: forces on a chain that a cubic spring exerts as well."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import SENSORS
from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring, Effect
from fe_models.measurement import lowpassed
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.fitting.geometry_response import added_motion
from hybrid.diagnosis.nominal.geometry import Geometry
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.batches import batches_of
from hybrid.diagnosis.response.hypothesis import Hypothesis
from tests.test_diagnosis_loads import (
    OUTPUTS,
    RATE,
    SAMPLES,
    START,
    HarmonicForces,
    chain_motion,
    harmonic_forces,
    load_of,
)

STIFFNESS = 0.004  # N/m^3
GEOMETRY = Geometry(np.eye(4)[:, [2]], np.ones(1), np.array([[3]]), np.array([[-STIFFNESS]]), np.zeros((1, 4)))
SPRING = CubicSpring((3,), "x", STIFFNESS)  # exerts the same
LAWS = {"linear": (), "stiff": (CubicSpring((1,), "x", 0.5),), "soft": (CubicSpring((1,), "x", -0.02),)}


def difference(laws: tuple[Effect, ...], pushed: HarmonicForces = ()) -> FloatArray:
    """Return what Exudyn shows with the spring less what it shows without, (time, sensor)."""
    with_it, without = (chain_motion(pushed, START, *effects) for effects in ((*laws, SPRING), laws))
    return (with_it - without)[:, :4]


def geometric_motion(
    laws: tuple[Effect, ...],
    pushed: HarmonicForces = (),
    lowpass: float | None = None,
    geometry: Geometry = GEOMETRY,
    starts: FloatArray = START[None],
) -> FloatArray:
    """Return what geometry adds to motions that begin at ``starts`` (recording, 2, dof), (recording, time, sensor)."""
    loads = (load_of(pushed),) if pushed else ()
    parts = tuple(Recording(f"r{i}", np.zeros((1, SAMPLES, len(SENSORS))), loads=loads) for i in range(len(starts)))
    dataset = Dataset(four_dof().with_effects(*laws), RATE, SENSORS, parts, lowpass)
    (batch,) = batches_of(dataset, "train")
    hypothesis = Hypothesis(replace(nominal_model_of(dataset), geometry=geometry))
    return added_motion(hypothesis, hypothesis.centre, starts.reshape(len(starts), -1), batch, OUTPUTS)


def assert_close(found: FloatArray, expected: FloatArray, tolerance: float) -> None:
    """Channels (time, sensor), each within its share of its own largest value."""
    assert (np.abs(found - expected).max(axis=0) < tolerance * np.abs(expected).max(axis=0)).all()


@pytest.mark.parametrize(
    "pushed", [(), harmonic_forces(1, node=3), harmonic_forces(1, node=3, highest=2.0)], ids=["free", "slow", "fast"]
)
@pytest.mark.parametrize("laws", LAWS.values(), ids=LAWS)
def test_geometry_adds_what_a_spring_that_exerts_the_same_does(
    laws: tuple[Effect, ...], pushed: HarmonicForces
) -> None:
    """Beside force laws, which answer to it, and under known loads up to a fifth of the sampling rate."""
    # What the last round changes of the forces, 1 %, changes the motion by a tenth of that.
    assert_close(geometric_motion(laws, pushed)[0], difference(laws, pushed), 2e-3)


@pytest.mark.parametrize("laws", LAWS.values(), ids=LAWS)
def test_what_it_adds_passes_the_low_pass_of_the_recordings(laws: tuple[Effect, ...]) -> None:
    found, whole = geometric_motion(laws, lowpass=0.3)[0], geometric_motion(laws)[0]
    inside = slice(100, -100)  # as far as the filter reaches
    expected = lowpassed(whole, RATE, 0.3)[inside]
    assert_close(found[inside], expected, 5e-3)  # a filter at 10 Hz is not quite the one at 20 Hz
    taken = np.abs(whole[inside] - expected).max(axis=0) / np.abs(expected).max(axis=0)
    assert (taken[1:] > 0.2).all()  # of the accelerations it takes away much


@pytest.mark.parametrize("laws", LAWS.values(), ids=LAWS)
def test_recordings_side_by_side_are_as_each_alone(laws: tuple[Effect, ...]) -> None:
    starts = np.stack([START, -0.5 * START[::-1]])
    both = geometric_motion(laws, starts=starts)
    for one, start in zip(both, starts, strict=True):
        # as above: one alone settles in other rounds
        assert_close(geometric_motion(laws, starts=start[None])[0], one, 2e-3)


@pytest.mark.parametrize("laws", LAWS.values(), ids=LAWS)
def test_what_gives_way_goes_with_the_square_of_the_motion(laws: tuple[Effect, ...]) -> None:
    """Node 4 gives way by 0.1 u^2 of its own, without any force: its displacement shows that, node 1 nothing."""
    square = Geometry(np.eye(4)[:, [3]], np.ones(1), np.array([[2]]), np.zeros((1, 1)), 0.1 * np.eye(4)[[3]])
    found, u = geometric_motion(laws, geometry=square)[0], chain_motion((), START, *laws)[:, 0]
    assert_close(found[:, :1], 0.1 * u[:, None] ** 2, 1e-4)  # the laws' own steps
    assert np.abs(found[:, 1]).max() < 1e-9  # rounding


@pytest.mark.parametrize("laws", [(), (CubicSpring((1,), "x", -0.5),)], ids=["by geometry", "without it"])
def test_a_motion_that_explodes_has_nothing_added(laws: tuple[Effect, ...]) -> None:
    soft = replace(GEOMETRY, forces=np.array([[0.5]]))
    assert not geometric_motion(laws, geometry=soft).any()
