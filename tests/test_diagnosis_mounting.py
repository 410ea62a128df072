"""Sensors that are not where the dataset says: no cause of the list, but reported."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.causes import CubicSpring
from fe_models.recordings import Dataset
from fe_models.structure import PointMass
from hybrid.diagnosis.contest.growing import reference_fits_of
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.outcome.mounting import mounting_of
from tests.masts import SENSORS, masts, recorded


def mounting_note(dataset: Dataset) -> str | None:
    """What is said of the mounting of a dataset's sensors."""
    setting = setting_of(dataset)
    ground = reference_fits_of(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths, setting.noise_model
    )
    assert ground is not None
    return mounting_of(ground.whole, setting.noise_model)


def is_off(heavier: float) -> Dataset:
    """Recordings of masts whose top masses are ``heavier``, held against the drawn ones."""
    design = masts()
    masses = tuple(PointMass(m.node, m.mass * (heavier if m.node in (3, 6) else 1.0)) for m in design.point_masses)
    return replace(recorded(replace(design, point_masses=masses)), model=design)


@pytest.mark.slow
@pytest.mark.parametrize("heavier", [1.0, 1.02])
@pytest.mark.parametrize(("one", "other"), [(0, 2), (0, 1), (1, 3)])
def test_exchanged_sensors_are_reported(heavier: float, one: int, other: int) -> None:
    sound = is_off(heavier)
    order = list(range(len(SENSORS)))
    order[one], order[other] = other, one
    exchanged = tuple(replace(r, data=r.data[..., order]) for r in sound.recordings)
    sentence = mounting_note(replace(sound, recordings=exchanged))
    assert sentence is not None
    assert sentence.startswith(
        f"sensors {SENSORS[one].name} and {SENSORS[other].name} in each other's place would take "
    )


@pytest.mark.parametrize("heavier", [1.0, 1.02])
def test_sensor_at_another_place_is_reported(heavier: float) -> None:
    said = replace(SENSORS[0], node=3)
    sentence = mounting_note(replace(is_off(heavier), sensors=(said, *SENSORS[1:])))
    assert sentence is not None
    assert sentence.startswith(f"sensor {said.name} at node 2 in x, not at node 3 in x, would take ")


@pytest.mark.parametrize("heavier", [1.0, 1.02])
def test_sensors_in_their_places_are_not_reported(heavier: float) -> None:
    assert mounting_note(is_off(heavier)) is None


def test_a_spring_is_no_mounting() -> None:
    assert mounting_note(recorded(masts(), CubicSpring((3,), "x", 5e7))) is None


def test_a_faulty_channel_is_no_mounting() -> None:
    """Samples that are lost are nowhere else."""
    sound = recorded(masts())
    lost = np.where(np.arange(sound.recordings[0].data.shape[1])[:, None] % 100 < 40, [0.0, 1.0, 1.0, 1.0], 1.0)
    assert (
        mounting_note(replace(sound, recordings=tuple(replace(r, data=r.data * lost) for r in sound.recordings)))
        is None
    )
