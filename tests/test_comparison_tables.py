"""The comparison of recordings as files: every number where it belongs."""

import csv
import io
import json
from dataclasses import replace

import numpy as np
import pytest

from fe_models.recordings import Sensor
from hybrid.identification.backbone import Backbone
from hybrid.identification.combinations import Combination
from hybrid.identification.comparison_report import by_chance
from hybrid.identification.comparison_tables import comparison_csv, comparison_table
from hybrid.identification.dataset_comparison import without_a_scale
from hybrid.identification.identification import Identification
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.recording_comparison import Compared, Observed
from hybrid.identification.stabilisation import Stabilisation

RATIOS = np.array([0.01, 0.02, 0.03])
IDENTIFIED = IdentifiedModes(
    roots=2 * np.pi * np.array([2.2, 3.1, 5.0]) * (-RATIOS + 1j * np.sqrt(1 - RATIOS**2)),
    shapes=np.array([[1.0, 0.4, -0.5], [0.2, 1.0, 1.0]], dtype=complex),
    reference=np.array([0, 1, 1]),
    covariance=np.tile(1e-6 * np.eye(6), (3, 1, 1)),
    energy=np.array([0.6, 0.1, 0.25]),
    left=0.05,
    orders=np.zeros(2, dtype=int),
    sizes=np.ones(2),
)
POLES = Stabilisation(np.array([2]), IDENTIFIED.roots[:1], IDENTIFIED.shapes.T[:1], np.array([0]))
CURVES = (
    Backbone(*np.array([[0.3, 0.1], [2.2, 2.3], [0.01, 0.02], [0.001, 0.004], [0.002, 0.003]])),
    Backbone(*np.zeros((5, 0))),
)
OBSERVED = Observed(
    name="monday, early",
    lasts=10.0,
    found=Identification(IDENTIFIED, POLES, is_ambient=False),
    shapes=IDENTIFIED.real_shapes,
    criterion=np.array([[0.99, 0.5, 0.1], [0.2, 0.3, 0.97], [0.1, 0.1, 0.1]]),
    chosen=(0, 2, -1),
    backbones=CURVES,
    combinations=(Combination(1, 1, 7.2, 7.21, 0.1, 30.0), Combination(2, 0, 44.0)),
)
COMPARED = Compared(
    nominal=np.array([2.0, 5.0, 9.0]),
    shapes=np.array([[1.0, -0.5, 0.3], [0.2, 1.0, -0.7]]),
    sensors=("x1", "x2"),
    followed=(0, 1),
    recordings=(OBSERVED,),
    left=np.array([[0.05]]),
    window=5.0,
)


def test_shapes_at_few_sensors_are_said_to_agree_by_chance() -> None:
    assert by_chance(1).startswith("One sensor has no shape")
    assert "in 20% of cases" in by_chance(2)
    assert "in 5% of cases" in by_chance(3)
    assert by_chance(4) == ""
    rng = np.random.default_rng(0)
    shapes, others = rng.standard_normal((2, 3, 20_000))
    criterion = np.sum(shapes * others, axis=0) ** 2 / np.sum(shapes**2, axis=0) / np.sum(others**2, axis=0)
    assert np.mean(criterion > 0.9) == pytest.approx(0.05, abs=0.006)  # four standard deviations


def test_each_mode_of_each_recording_is_a_row() -> None:
    rows = list(csv.DictReader(io.StringIO(comparison_csv(COMPARED))))
    assert [row["mode"] for row in rows] == ["1", "", "2"]
    assert {row["recording"] for row in rows} == {"monday, early"}
    first, other, last = rows
    numbers = [float(first[name]) for name in ("frequency_hz", "damping_ratio", "mac", "energy_share")]
    assert numbers == pytest.approx([2.2, 0.01, 0.99, 0.6])
    assert float(first["deviation"]) == pytest.approx(0.1)
    assert float(last["nominal_frequency_hz"]) == 5.0
    assert float(last["mac"]) == 0.97
    assert other["mac"] == other["nominal_frequency_hz"] == other["deviation"] == ""
    assert float(other["frequency_hz"]) == 3.1


def test_the_table_is_json_and_holds_what_was_found() -> None:
    table = json.loads(json.dumps(comparison_table(COMPARED), allow_nan=False))
    assert [each["frequency"] for each in table["model"]] == [2.0, 5.0, 9.0]
    assert table["model"][1]["shape"] == [-0.5, 1.0]
    (recording,) = table["recordings"]
    assert recording["unexplained_energy"] == 0.05
    assert [each["mode"] for each in recording["modes"]] == [1, None, 2]
    assert recording["modes"][2]["shape"] == [-0.5, 1.0]
    assert recording["while_it_decays"][0]["frequency_hz"] == [2.2, 2.3]
    assert recording["while_it_decays"][1]["amplitude"] == []
    assert [curve["amplitude_at"] for curve in recording["while_it_decays"]] == ["x1", "x2"]
    near, beyond = recording["combinations"]
    assert (near["factors"], near["found_hz"], near["power_over_surroundings"]) == ([1, 1], 7.21, 30.0)
    assert (beyond["expected_hz"], beyond["found_hz"], beyond["power_over_surroundings"]) == (44.0, None, None)
    assert table["left_by_modes_of_each"] == {"window_seconds": 5.0, "shares": [[0.05]]}


def test_normalised_channels_without_a_common_scale_are_told() -> None:
    plain = Sensor("a1", 1, "x", "acceleration", "m/s^2")
    bare, moved = replace(plain, name="a2", unit="1"), replace(plain, name="x3", quantity="displacement", unit="1")
    assert without_a_scale([plain, plain]) == without_a_scale([bare, bare]) == ()
    (note,) = without_a_scale([plain, bare])
    assert note.startswith('a2: of unit "1", normalised, beside sensors')
    assert without_a_scale([bare, moved])[0].startswith("a2, x3: ")
