"""Channels that hardly move are left out, and said to be; those in another unit, or quiet by chance, are not."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.assembly import linearise
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import Beam, Damping, Direction, Structure, Support
from hybrid.diagnosis.recorded.motionless_channels import without_motionless
from tests.masts import TUBE

PORTAL = Structure(
    name="portal",
    nodes=((0.0, 0.0), (0.0, 3.0), (4.0, 3.0), (4.0, 0.0)),
    elements=tuple(Beam((i, i + 1), TUBE) for i in (1, 2, 3)),
    supports=(Support(1, ("x", "y", "rz")), Support(4, ("x", "y"))),
    damping=Damping(modal_ratios=(0.01,)),
).refined(4)
PLACES: tuple[tuple[int, Direction], ...] = ((2, "x"), (3, "x"), (3, "y"))
SENSORS = tuple(Sensor(f"a{node}{direction}", node, direction, "acceleration", "m/s^2") for node, direction in PLACES)


def recorded(*sizes: float) -> Dataset:
    """Return a motion with these standard deviations of the sensors' channels, m/s^2."""
    data = np.random.default_rng(0).standard_normal((1, 400, 3)) * sizes
    return Dataset(PORTAL, 100.0, SENSORS, (Recording("r1", data), Recording("r2", 0.5 * data, "test")))


@pytest.mark.parametrize(
    ("sizes", "kept"),
    [
        ((1.0, 1.0, 6e-4), ("a2x", "a3x")),  # as the frame sways
        ((1.0, 1.0, 0.02), ("a2x", "a3x", "a3y")),  # turned by a degree, or more than the model has: to be explained
        ((1.0, 8e-4, 8e-4), ("a2x", "a3x")),  # in mm/s^2: the model has a3x in motion
    ],
)
def test_what_neither_recordings_nor_model_have_in_motion_is_left_out(
    sizes: tuple[float, ...], kept: tuple[str, ...]
) -> None:
    modal = natural_modes(linearise(PORTAL), 2)
    found, notes = without_motionless(recorded(*sizes), modal.dofs, modal.shapes)
    assert tuple(sensor.name for sensor in found.sensors) == kept
    assert {recording.data.shape[-1] for recording in found.recordings} == {len(kept)}
    assert len(notes) == 3 - len(kept)
    assert all("a3y hardly moves" in note for note in notes)


def test_a_sensor_alone_in_its_unit_has_none_to_be_compared_with() -> None:
    modal = natural_modes(linearise(PORTAL), 2)
    dataset = recorded(1.0, 1.0, 6e-4)
    apart = replace(dataset, sensors=(*SENSORS[:2], replace(SENSORS[2], quantity="velocity", unit="m/s")))
    assert without_motionless(apart, modal.dofs, modal.shapes) == (apart, [])
