"""The bridge's laboratory recordings as a dataset: with stand-ins of the same format, and the real ones."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat, savemat

from fe_models.built_in.bridge import bridge
from fe_models.errors import InputError
from fe_models.files.bridge_recordings import write_bridge_dataset
from fe_models.files.dataset_file import load_dataset

REAL = Path(__file__).parents[2] / "shared" / "data" / "bridge"


@pytest.fixture
def stand_ins(tmp_path: Path) -> Path:
    """A folder of recordings with the authors' names and format."""
    rng = np.random.default_rng(0)
    time = np.arange(500)[:, None] * 0.01
    for number in range(1, 5):
        decay = np.exp(-0.3 * time) * np.cos(2 * np.pi * 3.45 * time) * rng.standard_normal(8)
        savemat(tmp_path / f"acc_measured{number}.mat", {"acc_measured": decay, "dt": 0.01})
    return tmp_path


def test_one_recording_is_for_testing_and_a2_is_held_out(stand_ins: Path, tmp_path: Path) -> None:
    dataset = load_dataset(write_bridge_dataset(stand_ins, tmp_path / "out", test=3))
    assert dataset.model == bridge()
    assert [recording.name for recording in dataset.select("test")] == ["r3"]
    assert [recording.name for recording in dataset.select("train")] == ["r1", "r2", "r4"]
    assert [sensor.name for sensor in dataset.sensors if sensor.role == "held_out"] == ["A2"]
    places = [(sensor.node, sensor.direction) for sensor in dataset.sensors]
    assert places == [(5, "y"), (9, "y"), (12, "y"), (15, "y"), (18, "y"), (21, "y"), (40, "x"), (53, "x")]
    assert (dataset.sampling_rate, dataset.lowpass) == (100.0, 30.0)


def test_what_is_missing_or_unknown_comes_out_at_once(stand_ins: Path, tmp_path: Path) -> None:
    (stand_ins / "acc_measured2.mat").unlink()
    (stand_ins / "acc_measured4.mat").unlink()
    with pytest.raises(InputError) as caught:
        write_bridge_dataset(stand_ins, tmp_path / "out", test=7, held_out="B1")
    words = ("test recording 7", "sensor 'B1'", "acc_measured2.mat: no such file", "acc_measured4.mat: no such file")
    assert len(caught.value.faults) == len(words)
    for fault, word in zip(caught.value.faults, words, strict=True):
        assert word in fault
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(not REAL.is_dir(), reason="the bridge's recordings are not at hand (see the README)")
@pytest.mark.parametrize("test", [1, 2, 3, 4])
def test_the_real_recordings_pass_every_check(tmp_path: Path, test: int) -> None:
    dataset = load_dataset(write_bridge_dataset(REAL, tmp_path, test))
    assert len(dataset.recordings) == 4
    for number, recording in enumerate(dataset.recordings, start=1):
        original = loadmat(REAL / f"acc_measured{number}.mat")["acc_measured"]
        np.testing.assert_array_equal(recording.data[0], original)


@pytest.mark.skipif(not REAL.is_dir(), reason="the bridge's recordings are not at hand (see the README)")
def test_a_wrong_sampling_rate_for_the_real_recordings_is_found(tmp_path: Path) -> None:
    path = write_bridge_dataset(REAL, tmp_path, 1)
    for number in range(1, 5):  # without the time step that the authors stored
        savemat(
            tmp_path / f"acc_measured{number}.mat",
            {"acc_measured": loadmat(REAL / f"acc_measured{number}.mat")["acc_measured"]},
        )
    text = path.read_text().replace(REAL.resolve().as_posix(), tmp_path.as_posix())
    path.write_text(text)
    load_dataset(path)
    for rate in (50.0, 125.0, 200.0):
        path.write_text(text.replace("sampling_rate = 100.0", f"sampling_rate = {rate}"))
        with pytest.raises(InputError, match="a wrong sampling rate for its low-pass"):
            load_dataset(path)
