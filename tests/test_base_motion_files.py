"""Base motion and the reference of sensors in dataset files: read, saved, and every fault told at once."""

from dataclasses import replace
from math import cos, pi, sin
from pathlib import Path

import numpy as np
import pytest

from fe_models.assembly import unsupported
from fe_models.base_motion import BaseMotion, base_force, rigid_motion, unit_vector
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset, save_dataset
from fe_models.interpolant import Course
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import PointMass, Spring, Structure
from tests.sample_dataset import MAST

CHAIN = Structure(
    name="cart",
    nodes=((0.0, 0.0), (1.0, 0.0)),
    directions=("x",),
    elements=(Spring((1,), "x", 100.0), Spring((1, 2), "x", 150.0)),
    point_masses=(PointMass(1, 2.0), PointMass(2, 3.0)),
)
SENSORS = (
    Sensor("a1", 1, "x", "acceleration", "m/s^2"),
    Sensor("d2", 2, "x", "displacement", "m", reference="base"),
)
MOTION = np.random.default_rng(0).standard_normal((64, 2))
ACCELERATION = np.random.default_rng(1).standard_normal(64)
HEAD = """
schema = 1
model = "model.toml"
sampling_rate = 50.0
sensors = [
    { name = "a1", node = 1, direction = "x", quantity = "acceleration", unit = "m/s^2" },
    { name = "d2", node = 2, direction = "x", quantity = "displacement", unit = "m", reference = "base" },
]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    save_dataset(Dataset(CHAIN, 50.0, SENSORS, (Recording("r", MOTION[None]),)), tmp_path)
    lines = [",".join(("a1", "d2", "base")), *(f"{a},{d},{g}" for (a, d), g in zip(MOTION, ACCELERATION, strict=True))]
    (tmp_path / "table.csv").write_text("\n".join(lines))
    np.savez(tmp_path / "short.npz", g=np.append(ACCELERATION[:40], np.inf))
    return tmp_path


def read(folder: Path, base: str) -> Dataset:
    table = f'[[recordings]]\nname = "r"\nfile = "table.csv"\n{base}\n'
    (folder / "shaken.toml").write_text(HEAD + table)
    return load_dataset(folder / "shaken.toml")


def test_a_column_beside_the_responses_is_the_base_motion_in_g(folder: Path) -> None:
    dataset = read(folder, 'base = [{ direction = "x", file = "table.csv", key = "base", unit = "g" }]')
    (motion,) = dataset.recordings[0].base
    np.testing.assert_allclose(motion.values, 9.80665 * ACCELERATION, rtol=1e-15)
    assert motion.along == (1.0, 0.0)
    assert [sensor.reference for sensor in dataset.sensors] == ["absolute", "base"]
    assert not dataset.notes  # the column is asked for
    assert dataset.is_loaded


@pytest.mark.parametrize(
    ("direction", "along"), [('"y"', (0, 1)), ("30", (cos(pi / 6), sin(pi / 6))), ("[3, 4]", (0.6, 0.8))]
)
def test_a_base_moves_along_an_axis_an_angle_or_a_vector(
    folder: Path, direction: str, along: tuple[float, float]
) -> None:
    np.savez(folder / "base.npz", g=ACCELERATION)
    frame = replace(CHAIN, directions=("x", "y"), elements=(*CHAIN.elements, *(Spring((n,), "y", 9.0) for n in (1, 2))))
    save_dataset(Dataset(frame, 50.0, SENSORS, (Recording("r", MOTION[None]),)), folder)
    dataset = read(folder, f'base = [{{ direction = {direction}, file = "base.npz", key = "g" }}]')
    np.testing.assert_allclose(dataset.recordings[0].base[0].along, along, rtol=1e-15)


def test_a_saved_dataset_keeps_its_base_motion_and_references(tmp_path: Path) -> None:
    base = (BaseMotion("x", ACCELERATION), BaseMotion((1.0, 0.0), -ACCELERATION), BaseMotion(10.0, ACCELERATION))
    saved = Dataset(CHAIN, 50.0, SENSORS, (Recording("r", MOTION[None], base=base),))
    again = load_dataset(save_dataset(saved, tmp_path))
    assert [motion.direction for motion in again.recordings[0].base] == ["x", (1.0, 0.0), 10.0]
    for motion, given in zip(again.recordings[0].base, base, strict=True):
        np.testing.assert_array_equal(motion.values, given.values)
    assert again.sensors == SENSORS


def test_all_faults_of_base_motions_are_told_at_once(folder: Path) -> None:
    with pytest.raises(InputError) as caught:
        read(
            folder,
            "base = ["
            '{ direction = "up", file = "table.csv", key = "base" },'
            '{ direction = "x", file = "table.csv", key = "base", unit = "gal" },'
            '{ direction = "y", file = "table.csv", key = "base" },'
            '{ direction = [0, 0], file = "table.csv", key = "base" },'
            '{ direction = "x", file = "short.npz", key = "g" },'
            '{ direction = "x", file = "none.npz" }]',
        )
    faults = "\n".join(caught.value.faults)
    for part in (
        "base[1]: direction = 'up' is none that a base moves in; expected 'x', 'y', an angle in degrees",
        "base[2]: unit 'gal' is none of an acceleration; expected m/s^2 or g or mm/s^2",
        "base[3]: no node of this model moves in direction 'y'; the base would do nothing",
        "base[4]: direction = (0.0, 0.0) is none",
        "base[5]: short.npz: 41 values for 64 samples; one a sample is needed",
        "base[5]: short.npz: holds infinite values",
        "base[6]: ",
    ):
        assert part in faults
    assert len(caught.value.faults) == 7


def test_a_part_of_a_recording_has_that_part_of_the_base_motion() -> None:
    part = Recording("r", MOTION[None], base=(BaseMotion("x", ACCELERATION),)).part(3, 20)
    np.testing.assert_array_equal(part.base[0].values, ACCELERATION[3:20])


@pytest.mark.parametrize("course", ["smooth", "straight", "held"])
def test_a_part_goes_on_with_the_motion_of_the_whole(course: Course) -> None:
    """A constant and a ramp: of 0, 1, 2, ... held, the velocity at sample 4 is 0 + 1 + 2 + 3, else 4^2 / 2."""
    whole = BaseMotion("x", np.arange(20.0))
    part = Recording("r", MOTION[None, :20], base=(whole,)).part(4, None, course).base[0]
    assert part.begun[0] == pytest.approx(6.0 if course == "held" else 8.0, rel=1e-12)
    for of_part, of_whole in zip(part.integrals(course), whole.integrals(course), strict=True):
        np.testing.assert_allclose(of_part(np.arange(16)), of_whole(np.arange(4, 20)), rtol=1e-12)


def test_what_a_file_cannot_say_of_a_part_is_refused_or_noted(tmp_path: Path) -> None:
    """Sensors of acceleration, or of motion relative to the base, do not show with what velocity it begins."""
    part = Recording("r", MOTION[None], base=(BaseMotion("x", ACCELERATION),)).part(16)
    path = save_dataset(Dataset(CHAIN, 50.0, SENSORS, (part,)), tmp_path / "harmless")
    assert "# 'r' begins 16 samples after" in path.read_text()
    np.testing.assert_array_equal(load_dataset(path).recordings[0].data, part.data)
    absolute = (SENSORS[0], replace(SENSORS[1], reference="absolute"))
    with pytest.raises(InputError, match=r"'r': its base moves already when it begins.* d2 would be taken wrongly"):
        save_dataset(Dataset(CHAIN, 50.0, absolute, (part,)), tmp_path / "absolute")
    assert not (tmp_path / "absolute" / "dataset.toml").exists()
    held = Dataset(CHAIN, 50.0, SENSORS, (part,), load_course="held")
    with pytest.raises(InputError, match="load_course = 'held': a dataset file cannot say"):
        save_dataset(held, tmp_path / "held")


def test_the_base_carries_all_mass_of_a_structure_along() -> None:
    """Of a consistent mass, too, in part of which the supports take part: r^T M r is the whole mass."""
    mass, _, _ = unsupported(MAST)
    dofs = structure_dofs(MAST)
    for angle in (0.0, 37.0, 90.0):
        along = unit_vector(angle)
        r = rigid_motion(dofs, along)
        steel = 7850.0 * 1e-4 * 2.0
        assert -r @ base_force(mass, dofs, along) == pytest.approx(steel, rel=1e-12)  # rounding
    # In a translation of the whole, each end of a beam carries half of it; what moves with the free end alone is 13/35.
    lower = -base_force(mass, dofs, (1.0, 0.0))[dofs.row(2, "x")]
    assert lower == pytest.approx(7850.0 * 1e-4 * 1.0, rel=1e-12)  # half of each of two beams
