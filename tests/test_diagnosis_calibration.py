"""Nominal values as calibrated: how sure that is, and which are reported to be far off."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.fitting.calibration_deviation import deviation_of, deviation_of_groups
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.calibration import astray, calibration_of, far_off
from hybrid.diagnosis.recorded.batches import batches_of, columns_of, measured_columns
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis

DATASET = blind_case(2).dataset
MODEL = nominal_model_of(DATASET)


def test_values_that_nothing_tells_keep_their_stated_standard_deviation() -> None:
    """However much wider the temper would make it; what recordings tell well is as wide as the covariance says."""
    theta = np.zeros(len(MODEL.spread))
    theta[0] = np.log(1.1)
    covariance = np.diag(np.append(0.5 * MODEL.spread[0], 3 * MODEL.spread[1:]) ** 2)
    first, *others = calibration_of(MODEL, theta, covariance)
    assert np.isclose(first.factor, 1.1)
    assert np.isclose(first.std, 1.1 * 0.5 * MODEL.spread[0])
    np.testing.assert_allclose([item.std for item in others], MODEL.spread[1 : len(others) + 1])
    assert {item.factor for item in others} == {1.0}


def test_value_that_is_far_off_is_reported_with_its_place_and_side() -> None:
    columns = measured_columns(DATASET)
    noise_model = NoiseModel(
        tuple(DATASET.sensors[i] for i in columns), DATASET.sampling_rate, np.full(len(columns), 0.03)
    )
    hypothesis = Hypothesis(MODEL)
    found = fit(hypothesis, hypothesis.centre, columns_of(batches_of(DATASET, "train"), columns), noise_model)
    assert found is not None
    theta = np.zeros_like(found.theta)
    assert far_off(replace(found, theta=theta)) == []
    theta[1] = -3 * MODEL.spread[1]
    (note,) = far_off(replace(found, theta=theta))
    assert note.startswith("stiffness of element 2 is 3.0 of its stated standard deviations below")
    assert astray(replace(found, theta=theta), 4.0) == []
    theta[2] = 5 * MODEL.spread[2]
    (note,) = astray(replace(found, theta=theta), 4.0)
    assert "stiffness of element 3 had to go 5.0 of its stated standard deviations above" in note


@pytest.mark.slow
def test_element_that_is_far_off_by_itself_is_reported() -> None:
    setting = setting_of(blind_case(7, BlindConfig(tier="off", structure="bridge")).dataset)
    found, nominal = setting.short, setting.nominal
    theta, pattern = np.zeros_like(found.theta), nominal.scatter.weights[0]
    most = int(np.argmax(np.abs(pattern)))
    theta[nominal.factors] = -0.02 / pattern[most]  # a pattern's sign is free
    off = replace(found, theta=theta)
    (note,) = astray(off, 4.0)
    assert f"stiffness of element {nominal.scatter.elements[most]} had to go 2.0% below that of its group" in note
    assert deviation_of(off) == pytest.approx(4 * deviation_of_groups(off))  # a quarter of the group's is usual
