"""Directions of dataset files: axes, angles and vectors, of sensors and of loads."""

from pathlib import Path

import numpy as np
import pytest

from fe_models.directions import axis_and_sign, components
from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset
from fe_models.recordings import Dataset
from tests.sample_dataset import SAMPLES, TOML, free_decay, write_sample

LOAD = 'loads = [{ node = 3, direction = "x"'
SENSOR = 'name = "a2"\nnode = 2\ndirection = "x"'


def loaded(folder: Path, *changes: tuple[str, str]) -> Dataset:
    write_sample(folder)
    text = TOML
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    (folder / "dataset.toml").write_text(text)
    return load_dataset(folder / "dataset.toml")


@pytest.mark.parametrize(
    ("direction", "expected"),
    [
        ("rz", {"rz": 1.0}),
        (0.0, {"x": 1.0}),
        (90.0, {"y": 1.0}),
        (-180.0, {"x": -1.0}),
        (30.0, {"x": np.sqrt(0.75), "y": 0.5}),
        ((3.0, -4.0), {"x": 0.6, "y": -0.8}),
    ],
)
def test_a_direction_has_components_along_the_axes(direction: float, expected: dict[str, float]) -> None:
    assert components(direction) == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("direction", ["[0.0, 0.0]", "[1.0]"])
def test_what_is_no_direction_of_a_sensor_is_refused(tmp_path: Path, direction: str) -> None:
    with pytest.raises(InputError, match=r"sensors\[1\]\.direction: direction = .* is none"):
        loaded(tmp_path, (SENSOR, SENSOR.replace('"x"', direction)))


@pytest.mark.parametrize(("direction", "axis", "sign"), [("180", "x", -1), ("[0.0, -2.0]", "y", -1), ("90.0", "y", 1)])
def test_a_sensor_along_an_axis_or_against_it_shows_the_axis(
    tmp_path: Path, direction: str, axis: str, sign: int
) -> None:
    dataset = loaded(tmp_path, (SENSOR, SENSOR.replace('"x"', direction)))
    assert dataset.sensors[0].direction == axis
    np.testing.assert_array_equal(dataset.recordings[0].data[0, :, 0], sign * free_decay(1)[:, 0])
    assert axis_and_sign("x") == ("x", 1.0)


def test_a_load_between_axes_is_two_loads(tmp_path: Path) -> None:
    loads = loaded(tmp_path, (LOAD, LOAD.replace('"x"', "120"))).recordings[1].loads
    assert [(load.node, load.direction) for load in loads] == [(3, "x"), (3, "y")]
    np.testing.assert_allclose([load.values for load in loads], [[-0.5] * SAMPLES, [np.sqrt(0.75)] * SAMPLES])


def test_a_load_that_a_support_takes_whole_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"loads\[1\]: node 1 is held in x by a support; the load would do nothing"):
        loaded(tmp_path, (LOAD, LOAD.replace("node = 3", "node = 1").replace('"x"', "[1, 1]")))
