"""Small inputs that once went wrong, from the folder of cases beside the project: read, compared and learned from."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from fe_models.files.dataset_file import load_dataset
from hybrid.identification.recording_comparison import compare_recordings
from scripts.train_hybrid import app

CASES = Path(__file__).parents[2] / "shared" / "cases"
pytestmark = pytest.mark.skipif(not CASES.is_dir(), reason="the folder of cases is not here")


@pytest.mark.parametrize(
    ("file", "samples", "loads"),
    [
        ("csv_trailing_comma/trailing_comma.toml", 600, 0),
        ("csv_force_beside_response/force_in_same_csv.toml", 600, 1),
        ("rounded_time_column/dataset.toml", 600, 0),
    ],
)
def test_files_are_read_without_a_note(file: str, samples: int, loads: int) -> None:
    dataset = load_dataset(CASES / file)
    (recording,) = dataset.recordings
    assert (recording.data.shape[1], len(recording.loads), dataset.notes) == (samples, loads, ())


def test_one_mode_is_compared() -> None:
    compared = compare_recordings(load_dataset(CASES / "compare_one_mode" / "exact.toml"))
    assert compared.followed == (0,)
    for observed in compared.recordings:  # the model is exact
        assert observed.identified.frequencies[observed.chosen[0]] == pytest.approx(compared.nominal[0], rel=5e-3)


def test_a_rising_frequency_is_one_line() -> None:
    compared = compare_recordings(load_dataset(CASES / "compare_split_pole" / "dataset.toml"))
    rises = []
    for number, observed in enumerate(compared.recordings, start=1):
        mean = 0.0025 * number  # of the recording: half of what the frequency rises by in all
        found = observed.identified.frequencies[observed.chosen[0]] / compared.nominal[0] - 1
        assert found == pytest.approx(mean, abs=3e-3)  # whole millimetres, three periods
        ratio = observed.identified.ratios[observed.chosen[0]]
        assert ratio > 0.001  # 0.0028 was put in; none was what a split pole had
        rises.append(observed.backbones[0].frequency[-1] / observed.backbones[0].frequency[0] - 1)
    # the first and the last span lie half of the recording apart
    np.testing.assert_allclose(rises, 0.0025 * np.arange(1, 13), atol=6e-3)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["450_one", "450_two", "499_one", "499_two"])
def test_short_recordings_are_learned_from(name: str, tmp_path: Path) -> None:
    file = CASES / "train_one_window" / f"{name}.toml"
    answer = CliRunner().invoke(app, [str(file), "--out", str(tmp_path / "out"), "--epochs", "5"])
    assert answer.exit_code == 0, answer.output
    (line,) = [line for line in answer.output.splitlines() if line.startswith("measured channels")]
    assert float(line.split()[-1]) > 0.9  # R2 of the hybrid: ten samples tell the state to a few per cent
