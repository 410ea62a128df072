"""Recordings of ambient vibration beside one another: what changed is told from chance, and drawn."""

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.shear_frame import frame_modes, frame_recording, shear_frame
from fe_models.files.dataset_file import save_dataset
from fe_models.files.structure_file import save_structure
from fe_models.recordings import Dataset, Recording, Sensor
from hybrid.identification.ambient_modes import identify_ambient_modes
from hybrid.identification.comparison_report import describe_compared
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.mode_changes import RecordingChange, changes_among, states_among
from hybrid.identification.recording_comparison import Compared, compare_recordings
from hybrid.identification.shape_correlation import coordinate_mac
from hybrid.identification.structure_states import Outcome, states
from scripts.compare_recordings import app
from tests.blank_sheets import blank_sheets

RATE = 20.0
SENSORS = tuple(Sensor(f"a{node}", node, "x", "acceleration", "m/s^2") for node in range(1, 6))
LOST = {4: 0.3}  # of the fourth spring from the top


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    """Two recordings before and one after 30 % of a storey's stiffness was lost; nothing is said of the second."""
    line = 0.05 * np.cos(2 * np.pi * 3.3 * np.arange(14400) / RATE)[:, None]
    return Dataset(
        shear_frame(),
        RATE,
        SENSORS,
        (
            Recording("monday", frame_recording(0)[None], excitation="ambient"),
            Recording("tuesday", (frame_recording(1) + line)[None]),
            Recording("after", frame_recording(2, lost=LOST)[None], "test", excitation="ambient"),
        ),
    )


@pytest.fixture(scope="module")
def compared(dataset: Dataset) -> Compared:
    return compare_recordings(dataset)


def test_what_changed_is_plain_and_what_did_not_is_not(compared: Compared) -> None:
    plain = {change.recordings: change.is_plain for change in compared.changes}
    assert plain == {(0, 1): False, (0, 2): True, (1, 2): True}
    true = frame_modes(LOST).frequencies / frame_modes().frequencies - 1
    (change,) = (each for each in compared.changes if each.recordings == (0, 2))
    assert len(change.modes) == 5
    off = [(mode.change - true[mode.numbers[0]]) / mode.error for mode in change.modes]
    assert np.abs(off).max() < 4
    text = describe_compared(compared)
    assert text.startswith("The structure changed between the recordings, beyond chance: monday, tuesday; after are")
    assert "- tuesday: ambient, although nothing is said of what moved it: it does not die away" in text
    assert "- tuesday: a machine's line at 3.300 Hz, no mode" in text
    assert "While the motion decays" not in text  # nothing does


def test_the_coordinates_of_shapes_stand_in_the_text(compared: Compared) -> None:
    before, after = (compared.coordinate_mac(compared.recordings[number]) for number in (0, 2))
    assert before.min() > 0.99
    assert after.min() < 0.98  # storeys below and above the loss
    assert f"| after | {' | '.join(f'{value:.3f}' for value in after)} |" in describe_compared(compared)


@blank_sheets(".svg")
def test_the_command_saves_tables_and_pictures(dataset: Dataset, tmp_path: Path) -> None:
    short = replace(dataset, recordings=tuple(each.part(0, 6000) for each in dataset.recordings[::2]))
    save_structure(short.model, tmp_path / "frame.toml")  # type: ignore[arg-type]
    file = save_dataset(short, tmp_path / "data", "../frame.toml")
    out = tmp_path / "out"
    answer = CliRunner().invoke(app, [str(file), "--out", str(out)])
    assert answer.exit_code == 0, answer.output
    assert "The structure changed between the recordings, beyond chance: monday; after" in answer.output
    for name in ("spectra.png", "stabilisation.png", "mac.png", "comac.png"):
        assert (out / name).stat().st_size > 10_000
    assert not (out / "backbones.png").exists()
    table = json.loads((out / "comparison.json").read_text())
    assert table["changes"][0]["changed"]
    assert [recording["taken_as"] for recording in table["recordings"]] == ["ambient", "ambient"]
    assert table["left_by_modes_of_each"]["shares"] == [[None, None], [None, None]]
    first = table["recordings"][0]
    assert len(first["coordinate_mac"]) == 5
    assert np.array(first["mac"]).shape == (5, len(first["modes"]))
    rows = list(csv.DictReader((out / "comparison.csv").read_text().splitlines()))
    assert all(float(row["frequency_std_hz"]) > 0 and float(row["damping_ratio_std"]) > 0 for row in rows)


def test_recordings_may_have_rates_of_their_own() -> None:
    fast = frame_recording(3, 24_000, 50.0)
    mixed = Dataset(
        shear_frame(),
        RATE,
        SENSORS,
        (
            Recording("slow", frame_recording(0, 9600)[None], excitation="ambient"),
            Recording("fast", fast[None], excitation="ambient", sampling_rate=50.0),
        ),
    )
    found = compare_recordings(mixed)
    assert not found.changes[0].is_plain
    assert found.recordings[1].lasts == 480.0


@pytest.mark.slow
def test_recordings_of_one_state_are_seldom_called_changed() -> None:
    """Three dozens, each two of a dozen; and one of them with three that lost 30 % of a storey, any one."""
    clean = [_identified(frame_recording(seed)) for seed in range(36)]
    dozens = [clean[start : start + 12] for start in (0, 12, 24)]
    called = [change.is_plain for own in dozens for change in changes_among(own, _shapes(own))]
    assert len(called) == 198
    assert np.mean(called) <= 0.02
    for spring in range(1, 6):
        lost = [_identified(frame_recording(100 + 10 * spring + seed, lost={spring: 0.3})) for seed in range(3)]
        both = [clean[spring], *lost]
        found = changes_among(both, _shapes(both))
        assert all(change.is_plain == (change.recordings[0] == 0) for change in found)


def _identified(data: np.ndarray) -> IdentifiedModes:
    return identify_ambient_modes([data], RATE, 0.9, RATE / 2).modes


def _shapes(modes: list[IdentifiedModes]) -> list[np.ndarray]:
    return [each.real_shapes for each in modes]


def test_states_are_connected_by_what_did_not_change() -> None:
    same, other = 0.5, 1e-9
    changes = [
        RecordingChange((0, 1), (), other),
        RecordingChange((0, 2), (), same),
        RecordingChange((1, 2), (), other),
    ]
    assert states_among(changes, 3) == [[0, 2], [1]]
    assert "r1, r3; r2 are states of their own" in states(["r1", "r2", "r3"], changes).sentence
    assert "nothing changed beyond chance" in states(["r1", "r2"], [RecordingChange((0, 1), (), same)]).sentence
    assert "There is one recording" in states(["r1"], []).sentence


def test_recordings_without_a_mode_in_common_are_not_called_alike() -> None:
    low, high = made_up([1.0, 2.0]), made_up([10.0, 20.0])
    (change,) = changes_among([low, high], [np.eye(2), np.eye(2)])
    assert (change.modes, change.chance, change.is_plain) == ((), None, False)
    found = states(["r1", "r2"], [change])
    assert found.outcome is Outcome.OPEN
    assert found.sentence.endswith("is open: no mode is seen in both of r1 and r2.")


def test_a_mode_of_the_model_counts_however_far_it_moved() -> None:
    """By more than the 15 % that shapes alone are followed, while the other mode stays."""
    before, after = made_up([1.0, 5.0]), made_up([0.75, 5.0])
    numbers = [(0, 1), (0, 1)]
    (change,) = changes_among([before, after], [np.eye(2), np.eye(2)], numbers)
    assert [mode.change for mode in change.modes] == pytest.approx([-0.25, 0.0])
    assert change.is_plain


def test_a_mode_that_is_none_of_the_model_s_is_followed_by_its_shape() -> None:
    """As far as the sensors tell shapes apart, and unless the model says that these are two modes."""
    before, after = made_up([1.0, 5.0, 7.0]), made_up([0.75, 5.0, 7.0])
    (change,) = changes_among([before, after], [np.eye(3), np.eye(3)])
    assert [mode.change for mode in change.modes] == pytest.approx([-0.25, 0.0, 0.0])
    (two,) = changes_among([before, after], [np.eye(3), np.eye(3)], [(0, -1), (-1, 0)])
    assert [mode.numbers for mode in two.modes] == [(1, 1), (2, 2)]
    assert not two.is_plain


def test_many_recordings_have_as_many_states_as_there_are() -> None:
    """Seven before damage, six after it, and two of a third state: more than are compared each with each."""
    rng = np.random.default_rng(0)
    frequencies = [1.0] * 7 + [0.9] * 6 + [0.85] * 2
    found = [made_up([f * (1 + 1e-3 * rng.standard_normal()), 5.0]) for f in frequencies]
    changes = changes_among(found, [np.eye(2)] * 15)
    assert states_among(changes, 15) == [list(range(7)), list(range(7, 13)), [13, 14]]


def made_up(frequencies: list[float]) -> IdentifiedModes:
    """Modes whose frequencies are known to 0.1 %."""
    omega, count, ratio = 2 * np.pi * np.array(frequencies), len(frequencies), 0.01
    covariance = np.zeros((count, 2 + 2 * count, 2 + 2 * count))
    covariance[:, 0, 0] = covariance[:, 1, 1] = (1e-3 * omega) ** 2
    roots = np.asarray(omega * complex(-ratio, np.sqrt(1 - ratio**2)), dtype=np.complex128)
    shapes = np.eye(count, dtype=complex)
    energy, orders = np.full(count, 1 / count), np.zeros(count, dtype=int)
    return IdentifiedModes(roots, shapes, np.arange(count), covariance, energy, 0.0, orders, np.ones(count))


def test_the_coordinate_criterion_is_its_formula() -> None:
    """Two modes at two sensors: a sensor that moves alike in both has one; scale and sign of a mode do not matter."""
    shapes = np.array([[1.0, 1.0], [1.0, -1.0]])
    np.testing.assert_allclose(coordinate_mac(shapes, shapes * [3.0, -0.5]), 1.0)
    others = np.array([[1.0, 0.0], [0.0, 1.0]])
    # of norm one, a = 1 / sqrt 2 in all places: (a 1 + a 0)^2 / ((a^2 + a^2) 1) = 1 / 2
    np.testing.assert_allclose(coordinate_mac(shapes, others), 0.5)
    assert np.isnan(coordinate_mac(shapes[:, :0], others[:, :0])).all()
