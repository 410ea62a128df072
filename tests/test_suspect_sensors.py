"""A sensor that keeps shapes from being those expected is named, and nothing else is."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import fe_models as fe
from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modes_and_motion.faulty_sensors import notes_on_sensors
from hybrid.diagnosis.modes_and_motion.modal_diagnosis import diagnose_modes
from hybrid.identification.comparison_report import describe_compared
from hybrid.identification.recording_comparison import compare_recordings
from hybrid.identification.suspect_sensors import suspect_sensors
from tests.hybrid_problems import chain_dataset, chain_modes
from tests.test_modal_evidence import COUNT, RATE, SENSORS, chain, measured_of, modes_of

EXPECTED = np.array([1.9, 6.3, 13.0])
RNG = np.random.default_rng(0)
SHAPES = RNG.standard_normal((5, 3))
NAMES = ["a", "b", "c", "d", "e"]


def seen(fault: Callable[[FloatArray], FloatArray], seed: int = 1) -> FloatArray:
    """Return the shapes of any scale, with errors of a hundredth, as sensors with a ``fault`` show them."""
    rng = np.random.default_rng(seed)
    return fault(SHAPES * [2.0, -0.3, 1.0] + 0.01 * rng.standard_normal(SHAPES.shape))


def times(row: int, by: FloatArray | float) -> Callable[[FloatArray], FloatArray]:
    def scaled(shapes: FloatArray) -> FloatArray:
        shapes[row] *= by
        return shapes

    return scaled


@pytest.mark.parametrize(("gain", "words"), [(-1.0, "shows -1 times"), (1 / 9.81, "shows 0.1 times"), (0.0, "hardly")])
def test_one_sensor_with_a_gain(gain: float, words: str) -> None:
    found = suspect_sensors(EXPECTED, SHAPES, 0.97 * EXPECTED, seen(times(2, gain)))
    assert found is not None
    assert (found.sensors, found.modes) == ((2,), (0, 1, 2))
    assert found.gain == pytest.approx(gain, abs=0.05)
    told = found.words(NAMES, "the model's")
    assert "without sensor c" in told
    assert words in told


def test_what_differs_from_mode_to_mode_has_no_gain() -> None:
    found = suspect_sensors(EXPECTED, SHAPES, EXPECTED, seen(times(1, np.array([1.0, -3.0, 0.5]))))
    assert found is not None
    assert (found.sensors, found.gain) == ((1,), None)
    assert "does not go with the others" in found.words(NAMES, "the model's")


@pytest.mark.parametrize(
    ("derivative", "words"),
    [
        (-1, "a velocity does that is stated as an acceleration"),
        (1, "an acceleration does that is stated as a velocity"),
    ],
)
def test_another_derivative_than_is_stated(derivative: int, words: str) -> None:
    shapes = seen(lambda shapes: shapes).astype(complex)
    shapes[1] = shapes[1] * (2j * np.pi * EXPECTED) ** derivative
    found = suspect_sensors(EXPECTED, SHAPES, EXPECTED, shapes * np.exp([0.3j, -1.0j, 2.0j]))
    assert found is not None
    assert (found.sensors, found.gain, found.derivative) == ((1,), None, derivative)
    assert words in found.words(NAMES, "the model's")


def test_two_sensors_in_each_other_s_place() -> None:
    found = suspect_sensors(EXPECTED, SHAPES, EXPECTED, seen(lambda shapes: shapes[[0, 4, 2, 3, 1]]))
    assert found is not None
    assert found.sensors == (1, 4)
    assert "b and e in each other's place" in found.words(NAMES, "the model's")


def test_noise_in_a_mode_that_a_sensor_hardly_shows_is_no_fault() -> None:
    shapes = SHAPES * np.array([1.0, 1.0, 0.1])
    found = seen(lambda shapes: shapes)
    found[2, 2] = 2.0 * np.abs(found[:, 2]).max()
    assert suspect_sensors(EXPECTED, shapes, EXPECTED, found) is None


def test_right_sensors_are_not_suspected() -> None:
    assert suspect_sensors(EXPECTED, SHAPES, EXPECTED, seen(lambda shapes: shapes)) is None
    assert suspect_sensors(EXPECTED, SHAPES, 3 * EXPECTED, seen(times(2, -1.0))) is None  # other modes altogether
    assert suspect_sensors(EXPECTED, SHAPES, np.zeros(0), np.zeros((5, 0))) is None


@pytest.mark.parametrize("sensors", [1, 2, 3, 4, 8])
def test_another_structure_is_no_fault_of_a_sensor(sensors: int) -> None:
    rng = np.random.default_rng(sensors)
    told = 0
    for _ in range(200):
        shapes, others = rng.standard_normal((2, sensors, 3))
        told += suspect_sensors(EXPECTED, shapes, EXPECTED, others) is not None
    assert told <= 6  # 2 of 100 by chance


def turned(dataset: Dataset, number: int) -> Dataset:
    """Return a dataset with one sensor mounted the other way round."""
    signs = np.where(np.arange(len(dataset.sensors)) == number, -1.0, 1.0)
    recordings = tuple(
        Recording(recording.name, recording.data * signs, recording.role) for recording in dataset.recordings
    )
    return Dataset(dataset.model, dataset.sampling_rate, dataset.sensors, recordings)


def test_a_comparison_names_the_sensor_that_keeps_it_from_its_work() -> None:
    dataset = chain_dataset(chain_modes(), noise=0.005, realisations=1, samples=1000)
    assert "do not go with the others" not in describe_compared(compare_recordings(dataset))
    name = dataset.sensors[3].name
    try:
        text = describe_compared(compare_recordings(turned(dataset, 3)))
    except InputError as error:
        text = " ".join(error.faults)
    assert f"without sensor {name}: it shows -1 times what is expected" in text


def exchanged(own: MeasuredModes) -> MeasuredModes:
    """Return the modes as they look with the second and the fourth sensor in each other's place."""
    return replace(own, shapes=own.shapes[:, [0, 3, 2, 1, 4]])


def rate_of_third(own: MeasuredModes) -> MeasuredModes:
    """Return the modes as they look where the third sensor shows a velocity."""
    return replace(own, shapes=own.shapes * np.where(np.arange(COUNT) == 2, 1j * np.exp(own.log_omega)[:, None], 1.0))


def turned_third(own: MeasuredModes) -> MeasuredModes:
    """Return the modes as they look where the third sensor is mounted the other way round."""
    return replace(own, shapes=own.shapes * np.where(np.arange(COUNT) == 2, -1.0, 1.0))


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        (exchanged, "before, after: shapes at the frequencies of the model's modes .* with x2 and x4 in each other's"),
        (
            rate_of_third,
            "before.* without sensor x3: it moves as an acceleration does that is stated as a velocity, or a vel",
        ),
        (turned_third, None),  # a gain is on the list of causes
        (lambda own: own, None),
    ],
)
def test_a_diagnosis_notes_faults_that_are_no_cause(
    fault: Callable[[MeasuredModes], MeasuredModes], words: str | None
) -> None:
    rng = np.random.default_rng(3)
    off = [chain(1 + 0.05 * rng.standard_normal(COUNT)) for _ in range(2)]
    shown = (fault(modes_of(own, name, rng)) for own, name in zip(off, ("before", "after"), strict=True))
    still = Dataset(chain(), RATE, SENSORS, (Recording("before", rng.standard_normal((1, 100, COUNT))),))
    notes = notes_on_sensors(measured_of(still, *shown))
    assert len(notes) == (words is not None)
    assert words is None or re.match(words, notes[0])


@pytest.mark.slow
def test_a_velocity_stated_as_an_acceleration_is_no_friction() -> None:
    """Where modes are held as they are expected the motion strays as far as it does with friction."""
    true = ("a1", "a2", "a4", "x4", "v3")
    dataset = fe.simulate(fe.four_dof(), true, motions=12, duration=50.0, sampling_rate=10.0, noise=0.03)
    stated = replace(dataset.sensors[-1], quantity="acceleration", unit="m/s^2")
    found = diagnose_modes(replace(dataset, sensors=(*dataset.sensors[:-1], stated)))
    assert [finding.cause.kind for finding in found.findings] == ["sensor_gain"]
    assert any("moves as a velocity does that is stated as an acceleration" in note for note in found.notes)
