"""How known loads go between their samples: smooth, in straight lines, or held; and that recordings tell which."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.signal import butter, cont2discrete, dlsim, sosfiltfilt

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.base_motion import BaseMotion
from fe_models.interpolant import Course, interpolant
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Load, Recording, Sensor
from fe_models.structure import Damping, PointMass, Spring, Structure
from hybrid.diagnosis.nominal.loads import loads_of
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.batches import batches_of
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.series_diagnosis import diagnose_series
from hybrid.known_loads.modal_input import modal_input

RATE, SAMPLES = 100.0, 1500
OMEGA, RATIO, MASS = 2 * np.pi * 11.0, 0.03, 2.0
SENSORS = (Sensor("x", 1, "x", "displacement", "m"), Sensor("a", 1, "x", "acceleration", "m/s^2"))
CART = Structure(
    name="cart",
    nodes=((0.0, 0.0),),
    directions=("x",),
    elements=(Spring((1,), "x", MASS * OMEGA**2),),
    point_masses=(PointMass(1, MASS),),
    damping=Damping(modal_ratios=(RATIO,)),
)
HOLDS: dict[Course, str] = {"straight": "foh", "held": "zoh"}


@cache
def force(seed: int) -> FloatArray:
    """Return a random force (time,) up to 0.3 times the sampling rate, N."""
    white = np.random.default_rng(seed).standard_normal(SAMPLES)
    return np.asarray(100 * sosfiltfilt(butter(4, 0.3 * RATE, fs=RATE, output="sos"), white))


def moved(values: FloatArray, course: Course) -> FloatArray:
    """Return displacement and acceleration (time, 2) from rest, exact for a force that goes so between its samples."""
    A, B = np.array([[0.0, 1.0], [-(OMEGA**2), -2 * RATIO * OMEGA]]), np.array([[0.0], [1 / MASS]])
    C, D = np.array([[1.0, 0.0], A[1]]), np.array([[0.0], [1 / MASS]])
    discrete = cont2discrete((A, B, C, D), 1 / RATE, HOLDS[course])
    # scipy's discrete states of a first-order hold begin with the first value of the force: it is zero there
    return np.asarray(dlsim(discrete, np.append(0.0, values[1:]))[1])


def recorded(course: Course, noise: float = 0.0) -> Dataset:
    recordings = []
    for seed, name in enumerate(("train", "test")):
        values = np.append(0.0, force(seed)[1:])
        clean = moved(values, course)
        data = clean + noise * clean.std(axis=0) * np.random.default_rng(seed + 10).standard_normal(clean.shape)
        recordings.append(Recording(name, data[None], name, (Load(1, "x", values),)))  # type: ignore[arg-type]
    return Dataset(CART, RATE, SENSORS, tuple(recordings))


def test_courses_between_samples() -> None:
    values = np.array([0.0, 1.0, -2.0, 4.0])
    at = np.array([0.0, 0.5, 1.0, 1.25, 2.9])
    np.testing.assert_allclose(interpolant(values, course="straight")(at), [0.0, 0.5, 1.0, 0.25, 3.4], atol=1e-12)
    np.testing.assert_allclose(interpolant(values, course="held")(at), [0.0, 0.0, 1.0, 1.0, -2.0])
    velocity, displacement = BaseMotion("x", values).integrals("held")
    np.testing.assert_allclose(velocity([1, 2, 3]), [0.0, 1.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(displacement([1, 2, 3]), [0.0, 0.5, 0.5], atol=1e-12)


@pytest.mark.parametrize("course", ["straight", "held"])
def test_a_response_is_exact_for_the_course(course: Course) -> None:
    """Beside scipy's discrete systems, which are exact as well."""
    data = recorded(course)
    hypothesis = Hypothesis(nominal_model_of(data))
    system = system_of(hypothesis, np.zeros((1, hypothesis.nuisances)), SensorOutputs.faultless(SENSORS, RATE))
    still, size = np.zeros((1, 1, hypothesis.states)), data.recordings[0].data[0].std(axis=0)
    error = {}
    for taken in ("smooth", course):
        (batch,) = batches_of(replace(data, load_course=taken), "train")
        error[taken] = np.abs(respond(system, still, SAMPLES, batch.loads)[0, 0] - batch.data[0]).max(axis=0) / size
    assert error[course].max() < 1e-9
    assert error["smooth"].min() > 0.05


def test_loads_that_go_otherwise_are_those_of_a_dataset_that_says_so() -> None:
    rng = np.random.default_rng(0)
    whole = BaseMotion("x", rng.standard_normal(80))
    base = whole.part(20, None)  # begins with a velocity and a displacement
    recording = Recording("r", np.zeros((1, 60, 2)), loads=(Load(1, "x", rng.standard_normal(60)),), base=(base,))
    data = Dataset(CART, RATE, SENSORS, (recording,))
    smooth = loads_of([recording], 60, data)
    assert smooth is not None
    for course in ("straight", "held", "smooth"):
        said = loads_of([recording], 60, replace(data, load_course=course))
        assert said is not None
        going = smooth.going(course)
        for order in range(len(said.whole)):
            size = np.abs(smooth.whole[order]).max()
            np.testing.assert_allclose(going.whole[order], said.whole[order], atol=1e-9 * size)


def test_the_modal_model_takes_the_course_that_the_dataset_says() -> None:
    data = replace(recorded("straight"), load_course="straight")
    entered = modal_input(data, natural_modes(linearise(CART), 1), data.recordings)
    assert entered is not None
    courses, values = entered.courses(data.recordings[0]), data.recordings[0].loads[0].values
    np.testing.assert_allclose(courses[:-1, 1, 0], np.diff(values), atol=1e-9)
    assert np.abs(courses[:, 2:]).max() == 0


@pytest.mark.slow
@pytest.mark.parametrize("course", ["straight", "held"])
def test_recordings_tell_the_course_and_nothing_is_wrong(course: Course) -> None:
    found = diagnose_series(recorded(course, noise=0.003))
    assert found.verdict is Verdict.NOTHING_WRONG
    words = {"straight": "known forces go in straight lines", "held": "known forces hold each sample"}[course]
    assert sum(note.startswith(words) for note in found.notes) == 1
    extended = found.scores["extended"]["measured"]
    assert extended is not None
    assert extended < 1.15 * found.noise_floor  # by what the first fifth tells of the initial state
