"""Identified modes in a dataset file: what is read, every fault at once, the way back, and who needs recordings."""

from collections.abc import Callable
from dataclasses import fields, replace
from math import inf
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from typer.testing import CliRunner

from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset, save_dataset
from fe_models.mode_estimate import ModeEstimate
from hybrid.commands.app import app
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from hybrid.identification.recording_comparison import compare_recordings
from tests.sample_dataset import assert_fault, faults_of, write_sample

HEAD = """
schema = 1
model = "four_dof"
sensors = [
    { name = "x4", node = 4, direction = "x", quantity = "displacement", unit = "m" },
    { name = "a1", node = 1, direction = "x", quantity = "acceleration", unit = "m/s^2" },
]
"""
MODES = """
[[modes]]
recording = "before"
frequency = 0.0392
frequency_std = 1e-4
damping_ratio = 0.07
damping_std = 0.002
shape = [1.0, 0.4]
shape_std = 0.02

[[modes]]
recording = "before"
frequency = 0.174
shape = [[1, 0.01], [-0.7, 0.02]]

[[modes]]
recording = "after"
frequency = 0.0377
role = "test"
"""


def written(folder: Path, modes: str = MODES, head: str = HEAD) -> Path:
    path = folder / "modes.toml"
    path.write_text(head + modes)
    return path


def faults(folder: Path, *changes: tuple[str, str], head: str = HEAD) -> tuple[str, ...]:
    """Return the faults of the modes after ``changes``, each in the first place of the old words."""
    text = MODES
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    with pytest.raises(InputError) as caught:
        load_dataset(written(folder, text, head))
    return caught.value.faults


def assert_same(found: tuple[ModeEstimate, ...], expected: tuple[ModeEstimate, ...]) -> None:
    for one, other in zip(found, expected, strict=True):
        for item in fields(ModeEstimate):
            if item.name != "shape":
                assert getattr(one, item.name) == getattr(other, item.name)
        if one.shape is None or other.shape is None:
            assert one.shape is other.shape
        else:
            assert one.shape.dtype == other.shape.dtype
            np.testing.assert_array_equal(one.shape, other.shape)


def test_modes_alone_are_a_dataset(tmp_path: Path) -> None:
    dataset = load_dataset(written(tmp_path))
    expected = (
        ModeEstimate("before", 0.0392, 1e-4, 0.07, 0.002, np.array([1.0, 0.4]), 0.02),
        ModeEstimate("before", 0.174, shape=np.array([1 + 0.01j, -0.7 + 0.02j])),
        ModeEstimate("after", 0.0377, role="test"),
    )
    assert_same(dataset.modes, expected)
    assert (dataset.recordings, dataset.sampling_rate) == ((), inf)
    assert "3 identified modes of before, after; sensors x4, a1)" in repr(dataset)
    assert "motions" not in repr(dataset)
    assert repr(dataset.modes[0]) == (
        "ModeEstimate('before': 0.0392 +- 0.0001 Hz, damping ratio 0.07, shape at 2 sensors, train)"
    )


def test_modes_stand_beside_recordings(tmp_path: Path) -> None:
    path = write_sample(tmp_path) / "dataset.toml"
    path.write_text(path.read_text() + '\n[[modes]]\nrecording = "r1"\nfrequency = 2.5\nshape = [1, 2.0, 0]\n')
    dataset = load_dataset(path)
    assert_same(dataset.modes, (ModeEstimate("r1", 2.5, shape=np.array([1.0, 2.0, 0.0])),))
    assert "1 motions for training, 1 for testing" in repr(dataset)
    assert "; 1 identified mode of r1; sensors a2" in repr(dataset)


def test_a_dataset_without_modes_has_none(tmp_path: Path) -> None:
    dataset = load_dataset(write_sample(tmp_path) / "dataset.toml")
    assert dataset.modes == ()
    assert "identified" not in repr(dataset)


@pytest.mark.parametrize("rate", ["", "sampling_rate = 10.0\nlowpass = 4.0\n"])
def test_saved_modes_come_back(tmp_path: Path, rate: str) -> None:
    dataset = load_dataset(written(tmp_path, head=rate + HEAD))
    again = load_dataset(save_dataset(dataset, tmp_path / "new"))
    assert_same(again.modes, dataset.modes)
    assert (again.sampling_rate, again.lowpass) == (dataset.sampling_rate, dataset.lowpass)
    assert not list((tmp_path / "new").glob("*.npz"))  # all of it stands in the dataset file


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("shape = [1.0, 0.4]", "shape = [1.0, 0.4, 0.2]", "modes[1]: shape has 3 values for 2 sensors"),
        ("shape = [1.0, 0.4]", "shape = [0.0, 0]", "modes[1]: shape is zero everywhere"),
        ("[[1, 0.01], [-0.7, 0.02]]", "[[0, 0], [0, 0]]", "modes[2]: shape is zero everywhere"),
        ("[[1, 0.01], [-0.7, 0.02]]", "[[1, 0.01, 2], [-0.7, 0.02]]", "modes[2].shape: expected [a number or [a num"),
        ("shape = [1.0, 0.4]", "shape = [1.0, nan]", "modes[1].shape: expected"),
        ("frequency = 0.0392", "frequency = -0.0392", "modes[1]: frequency = -0.0392 Hz; must be positive"),
        ("frequency = 0.0392", "", "modes[1].frequency: missing; expected a number"),
        ('recording = "before"', "", "modes[1].recording: missing; expected text"),
        ("frequency_std = 1e-4", "frequency_std = -1e-4", "modes[1]: frequency_std = -0.0001; must be positive"),
        ("damping_std = 0.002", "damping_std = 0", "modes[1]: damping_std = 0; must be positive"),
        ("damping_ratio = 0.07\n", "", "modes[1]: damping_std stands without damping_ratio"),
        ("damping_ratio = 0.07", "damping_ratio = 7.0", "modes[1]: damping_ratio = 7; expected 0 <= ratio < 1"),
        ("shape_std", "shape_sd", "modes[1].shape_sd: unknown key; did you mean 'shape_std'?"),
        ('role = "test"', 'role = "hidden"', 'modes[3].role: expected "train" or "test", found "hidden"'),
        (
            "frequency = 0.174",
            'frequency = 0.174\nrole = "test"',
            "modes: 'before' has the role \"train\" in one place",
        ),
    ],
)
def test_a_fault_of_a_mode_is_named(tmp_path: Path, old: str, new: str, fault: str) -> None:
    found = faults(tmp_path, (old, new))
    assert_fault(found, f"modes.toml: {fault}")
    assert len(found) == 1


def test_all_faults_of_modes_come_out_at_once(tmp_path: Path) -> None:
    found = faults(
        tmp_path,
        ("frequency = 0.0392", "frequency = -1"),
        ("shape = [1.0, 0.4]", "shape = [0.0]"),
        ("shape_std = 0.02", "shape_std = -2\ncolour = 3"),
        ('role = "test"', 'role = "both"'),
        head=HEAD.replace("node = 4", "node = 9"),
    )
    for words in ("frequency = -1", "1 values for 2", "zero everywhere", "shape_std = -2", "colour", "both", "node 9"):
        assert_fault(found, words)
    assert len(found) == 7


def test_modes_need_sensors_and_something_to_fit(tmp_path: Path) -> None:
    found = faults(tmp_path, head='schema = 1\nmodel = "four_dof"\n')
    assert_fault(found, "sensors: there are none; give one [[sensors]] table a channel")
    assert len(found) == 1
    with pytest.raises(InputError, match='modes: none has the role "train"; at least one is needed'):
        load_dataset(written(tmp_path, '[[modes]]\nrecording = "r"\nfrequency = 1.0\nrole = "test"\n'))


def test_recordings_and_their_modes_have_one_role(tmp_path: Path) -> None:
    found = faults_of(
        write_sample(tmp_path), ("[simulation]", '[[modes]]\nrecording = "r2"\nfrequency = 1\n[simulation]')
    )
    assert_fault(found, 'modes: \'r2\' has the role "train" in one place and "test" in another')
    assert len(found) == 1


def test_a_split_gives_modes_the_role_of_their_recording(tmp_path: Path) -> None:
    dataset = load_dataset(write_sample(tmp_path) / "dataset.toml")
    split = replace(dataset, modes=(ModeEstimate("r2", 1.0), ModeEstimate("r1", 1.0), ModeEstimate("drawn", 1.0)))
    assert [mode.role for mode in split.split(0.5).modes] == ["test", "train", "train"]


@pytest.mark.parametrize(
    ("use", "what"), [(diagnose, "a diagnosis"), (compare_recordings, "a comparison of recordings")]
)
def test_modes_alone_are_refused_where_time_series_are_needed(
    tmp_path: Path, use: Callable[[Any], object], what: str
) -> None:
    with pytest.raises(InputError, match=f"identified modes alone, which {what} does not take yet: give it"):
        use(load_dataset(written(tmp_path)))


def test_a_prediction_needs_a_recording(tmp_path: Path) -> None:
    from hybrid.training.prediction import from_record  # loads PyTorch

    with pytest.raises(InputError, match="which a prediction does not take yet"):
        from_record(cast(Any, None), load_dataset(written(tmp_path)), None, 0.0, 10, whole=False)


@pytest.mark.parametrize("command", ["compare", "train"])
def test_commands_say_so_in_a_line(tmp_path: Path, command: str) -> None:
    ran = CliRunner().invoke(app, [command, str(written(tmp_path)), "--out", str(tmp_path / "out")])
    assert ran.exit_code == 2, ran.output
    (line,) = [line for line in ran.output.splitlines() if line.startswith("error:")]
    assert "the dataset has identified modes alone" in line
    assert not (tmp_path / "out").exists()
