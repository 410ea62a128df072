"""A sensor's fault beside a force law of a frame, where nothing else is looked for any more."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.effects import CubicSpring
from fe_models.recordings import Dataset
from fe_models.sensor_effects import SensorGain
from hybrid.diagnosis.contest.growing import ground_of
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.contest.stages import Search
from hybrid.diagnosis.fitting.fitting import Fit, fit
from tests.masts import RATE, SENSORS, masts, recorded

SPRING = CubicSpring((3,), "x", 5e7)
FAULT = SensorGain(SENSORS[0].name, 0.9)
NAMES = [sensor.name for sensor in SENSORS]


def searched(dataset: Dataset) -> tuple[Search, list[Fit]]:
    """Return the search of a dataset, and the fits without any cause and with the spring."""
    setting = setting_of(dataset)
    ground = ground_of(setting.nominal, setting.nominal.centre, setting.lengths, setting.gauge)
    assert ground is not None
    base, candidates = ground.whole, setting.candidates()
    (law,) = (c for c in candidates if c.kind == SPRING.kind and c.location == SPRING.location)
    best = fit(setting.nominal.adding(law), np.append(base.theta, 5e7), base.batches, setting.gauge, base.states)
    assert best is not None
    return Search(ground, setting.lengths, candidates, setting.gauge, setting.gauge, setting.band, str), [base, best]


def test_fault_that_explains_what_a_law_leaves_is_fitted_beside_it(monkeypatch: pytest.MonkeyPatch) -> None:
    right = recorded(masts(), SPRING)
    faulty = tuple(replace(r, data=FAULT.apply(r.data, NAMES, RATE)) for r in right.recordings)
    search, fits = searched(replace(right, recordings=faulty))
    monkeypatch.setattr(Search, "is_ample", lambda *_: True)  # as on a bridge, of whose energy one sensor shows little
    (found,) = search.faulty_sensor(fits)
    law, sensor = found.hypothesis.candidates
    assert (law.kind, sensor.kind, sensor.location) == (SPRING.kind, FAULT.kind, FAULT.location)
    assert found.theta[-1] == pytest.approx(FAULT.factor, abs=0.01)  # a tenth of the fault
    assert found.misfit < 0.2 * fits[1].misfit
    monkeypatch.setattr(Search, "is_ample", lambda *_: False)  # then all causes are looked for
    assert search.faulty_sensor(fits) == []


def test_no_fault_is_fitted_where_nothing_is_left_or_a_fault_explains_little_of_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Search, "is_ample", lambda *_: True)
    search, fits = searched(recorded(masts(), SPRING))
    assert search.faulty_sensor(fits) == []
    monkeypatch.setattr(Search, "is_wanting", lambda *_: True)
    more = replace(fits[1], cost=fits[1].cost + 1e4)  # of which no sensor promises to take half
    assert search.faulty_sensor([fits[0], more]) == []
