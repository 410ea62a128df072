"""Loads that were recorded late, or with a wrong scale: named as such, and nothing else blamed."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.causes import LoadDelay, LoadGain
from fe_models.files.dataset_file import load_dataset
from fe_models.interpolant import courses_of
from fe_models.recordings import Dataset, Load, Recording
from hybrid.diagnosis.nominal.load_channels import load_channels
from hybrid.diagnosis.nominal.loads import Loads
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.nominal.unstated_lowpass import unstated_lowpass
from hybrid.diagnosis.report import report_table
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from tests.load_problems import RATE, SENSORS, STOREYS, recordings

CASES = Path(__file__).parents[2] / "shared" / "cases"
needs_cases = pytest.mark.skipif(not CASES.is_dir(), reason="the folder of cases is not here")
TOP, EACH = np.array([0.0, 0.0, 1.0]), np.array([1.0, 1.0, 1.0])


def dataset(pull: FloatArray, late: float = 0.0, gain: float = 1.0) -> Dataset:
    return Dataset(STOREYS, RATE, SENSORS, recordings(pull, late, gain))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("late", "gain", "kind", "size"),
    [(0.1, 1.0, "load_delay", 0.1 / RATE), (-2.0, 1.0, "load_delay", -2 / RATE), (0.0, 1.2, "load_gain", 1.2)],
)
def test_a_load_with_a_fault_is_named_and_nothing_else(late: float, gain: float, kind: str, size: float) -> None:
    report = report_table(diagnose(dataset(TOP, late, gain)))
    (finding,) = report["findings"]
    assert (finding["kind"], finding["location"]) == (kind, {"load": [3, "x"]})
    assert finding["probability"] > 0.95
    (found,) = finding["parameters"].values()
    assert abs(found["value"] - size) < max(4 * found["std"], 1e-3 * abs(size))


@pytest.mark.slow
def test_a_load_that_was_recorded_well_is_not_blamed() -> None:
    report = report_table(diagnose(dataset(TOP)))
    assert report["verdict"] == "nothing_wrong"


def test_loads_that_pull_at_each_mass_as_a_moving_base_are_one_channel() -> None:
    at = [load_channels(own, nominal_model_of(own)) for own in (dataset(EACH), dataset(np.array([1.0, 2.0, 0.0])))]
    (base,), (pair,) = at
    assert (base.load, base.positions) == ("base", (0, 1, 2))
    assert (pair.load, pair.positions, pair.twins) == ((1, "x"), (0, 1), ((2, "x"),))


def test_loads_by_themselves_are_a_channel_each_and_one_together() -> None:
    first, second = np.random.default_rng(3).standard_normal((2, 900))
    two = [replace(r, loads=(Load(1, "x", first), Load(3, "x", second))) for r in recordings(TOP)]
    both = Dataset(STOREYS, RATE, SENSORS, tuple(two))
    assert [channel.load for channel in load_channels(both, nominal_model_of(both))] == [(1, "x"), (3, "x"), "all"]


@pytest.mark.parametrize("delay", [0.3, 5.0, -7.4])
def test_segments_take_what_a_late_load_was_from_beyond_their_ends(delay: float) -> None:
    """A smooth course, shifted by whole and broken samples, in the middle of a recording and at its cuts."""
    step, samples = 0.1, 400
    wave = np.sin(0.2 * np.arange(samples) + 0.3)
    loads = Loads.of(((1, "x"),), courses_of(wave[None, :, None], step), step).cut(4, 100)
    found = loads.acting(((1, "x"),), np.array([2.0]), np.array([delay * step]))[0, :, :, 0].ravel()
    truth = np.sin(0.2 * (np.arange(samples) + delay) + 0.3) / 2
    assert np.abs(found - truth)[20:-20].max() < 1e-9  # what a spline of degree seven loses at a thirtieth of the rate


def test_sentences_say_which_load_and_what_to_check() -> None:
    late = LoadDelay((5, "x"), 0.002).sentence({"delay": "0.002 s"}, STOREYS)
    assert late == ("The recorded load at node 5 in x is late by 0.002 s beside the sensors: check its clock.")
    assert LoadDelay((5, "x"), 0.002).location == {"load": [5, "x"]}
    gain = LoadGain("base", 1.1).sentence({"factor": "1.1"}, STOREYS)
    assert gain == "The recorded motion of the base is 1.1 times what acts: check its unit, calibration and sign."


@needs_cases
def test_what_falls_above_a_resonance_under_a_load_is_no_low_pass() -> None:
    forced = load_dataset(CASES / "forced_lowpass_note_linear" / "dataset.toml")
    assert unstated_lowpass(forced) == []
    free = tuple(Recording(r.name, r.data, r.role) for r in forced.recordings)
    assert unstated_lowpass(replace(forced, recordings=free))  # as it would be told of a free decay


@needs_cases
@pytest.mark.slow
@pytest.mark.parametrize("eighth", [2, 20])
def test_a_late_load_of_an_exact_model_is_told_to_a_fraction_of_a_sample(eighth: int) -> None:
    report = report_table(diagnose(load_dataset(CASES / "load_is_late" / f"late_{eighth}.toml")))
    (finding,) = report["findings"]
    assert (finding["kind"], finding["location"]) == ("load_delay", {"load": [5, "x"]})
    found = finding["parameters"]["delay"]
    assert found["value"] == pytest.approx(eighth / 40 / 100, abs=5 * found["std"])  # s: fortieths of a sample


@needs_cases
@pytest.mark.slow
def test_a_spring_and_an_early_base_motion_are_both_named() -> None:
    report = report_table(diagnose(load_dataset(CASES / "base_motion_early" / "early_2.toml")))
    found = {finding["kind"]: finding for finding in report["findings"]}
    assert found.keys() == {"load_delay", "stiffness_change"}
    assert found["load_delay"]["parameters"]["delay"]["value"] == pytest.approx(-5e-4, abs=5e-5)  # 1/20 of a sample
    assert found["stiffness_change"]["location"] == {"element": 3}
    assert found["stiffness_change"]["parameters"]["factor"]["value"] == pytest.approx(0.8, abs=0.02)


@needs_cases
@pytest.mark.slow
def test_a_single_mass_whose_last_spring_a_candidate_takes_is_diagnosed() -> None:
    report = report_table(diagnose(load_dataset(CASES / "crash_free_mass_loaded" / "dataset.toml")))
    assert report["findings"][0]["kind"] == "cubic_spring"
