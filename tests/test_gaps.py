"""Lost samples: a few are bridged where this serves, others cut a recording into stretches."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.base_motion import BaseMotion
from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset
from fe_models.files.gaps import mended
from fe_models.recordings import Dataset, Load, Recording
from tests.sample_dataset import NAMES, SAMPLES, TOML, broken, free_decay, write_sample

DATA = free_decay(1)
NOISE = np.random.default_rng(0).standard_normal((SAMPLES, 3))


def recording(data: FloatArray, **more: object) -> Recording:
    return replace(Recording("monday", data if data.ndim == 3 else data[None]), **more)  # type: ignore[arg-type]


def slow(period: float = 40.0) -> FloatArray:
    """Three channels of sines with that many samples a period, (time, channel)."""
    return np.asarray(np.sin(2 * np.pi * np.arange(SAMPLES)[:, None] / period + np.arange(3)))


@pytest.mark.parametrize("length", [1, 2, 3])
def test_short_gaps_are_bridged_by_a_cubic(length: int) -> None:
    """Forty samples a period: the cubic's error is (2 pi / 40)^4 / 4! times the distances to its four points, for one
    lost sample 2 * 1 * 1 * 2, for the middle of three 3 * 2 * 2 * 3: 1e-4 and 9.1e-4 of the amplitude.
    """
    whole, lost = slow(), slow()
    lost[100 : 100 + length, 1] = np.nan
    found = mended(recording(lost), NAMES)
    (stretch,) = found.stretches
    np.testing.assert_allclose(stretch.data[0], whole, atol=9.2e-4 if length == 3 else 4.1e-4)
    assert found.notes == (f"monday: {length} lost samples of a3 are bridged by cubics",)


def test_a_cubic_goes_through_a_cubic() -> None:
    whole = (np.arange(SAMPLES)[:, None] / SAMPLES - np.array([0.2, 0.5, 0.9])) ** 3
    lost = whole.copy()
    lost[[10, 50, 51, 200]] = np.nan
    np.testing.assert_allclose(mended(recording(lost), NAMES).stretches[0].data[0], whole, atol=1e-12)


@pytest.mark.parametrize("data", [NOISE, slow(3.0)])
def test_what_a_cubic_would_not_find_is_cut(data: FloatArray) -> None:
    """White noise, and three samples a period: bridging would make up what was never there."""
    lost = data.copy()
    lost[150, 2] = np.nan
    found = mended(recording(lost), NAMES)
    assert [(part.name, part.data.shape[1], part.skipped) for part in found.stretches] == [
        ("monday (1)", 150, 0),
        ("monday (2)", SAMPLES - 151, 151),
    ]
    (note,) = found.notes
    assert note == "monday: samples 151 to 151 are lost (d3); each stretch between is a recording of its own"


def test_long_gaps_cut_and_short_stretches_are_left_out() -> None:
    lost = slow()
    lost[100:120, 0] = np.nan
    lost[140:200, 1] = np.nan  # 20 samples between are too few
    found = mended(recording(lost, loads=(Load(1, "x", np.arange(float(SAMPLES))),)), NAMES)
    assert [part.data.shape[1] for part in found.stretches] == [100, 200]
    assert not any(np.isnan(part.data).any() for part in found.stretches)
    np.testing.assert_array_equal(found.stretches[1].loads[0].values, np.arange(200.0, 400.0))
    assert "samples 101 to 120, 141 to 200 are lost (a2, a3); each" in found.notes[0]
    assert "1 short one is left out" in found.notes[0]


def test_a_gap_at_an_end_leaves_the_recording_its_name() -> None:
    lost = slow()
    lost[:30] = np.nan
    (stretch,) = mended(recording(lost), NAMES).stretches
    assert (stretch.name, stretch.skipped, stretch.data.shape[1]) == ("monday", 30, SAMPLES - 30)


def test_a_lost_load_cuts_as_well() -> None:
    force = np.random.default_rng(1).standard_normal(SAMPLES)
    force[200] = np.nan
    found = mended(recording(slow(), loads=(Load(1, "x", force),)), NAMES)
    assert [len(part.loads[0].values) for part in found.stretches] == [200, SAMPLES - 201]
    assert "(its load or base motion)" in found.notes[0]


def test_a_lost_base_motion_cuts_as_well() -> None:
    shaking = np.random.default_rng(1).standard_normal(SAMPLES)
    shaking[200] = np.nan
    found = mended(recording(slow(), base=(BaseMotion("x", shaking),)), NAMES)
    assert [len(part.base[0].values) for part in found.stretches] == [200, SAMPLES - 201]
    assert all(np.isfinite((*part.base[0].values, *part.base[0].begun)).all() for part in found.stretches)


def test_motions_without_a_gap_stay_together() -> None:
    data = np.stack([slow(), slow(), slow(30.0)])
    data[1, 200:250, 0] = np.nan
    found = mended(recording(data), NAMES)
    assert [(part.name, part.data.shape[:2]) for part in found.stretches] == [
        ("monday", (2, SAMPLES)),
        ("monday [2] (1)", (1, 200)),
        ("monday [2] (2)", (1, 150)),
    ]
    np.testing.assert_array_equal(found.stretches[0].data, data[[0, 2]])


def test_a_recording_without_a_gap_is_left_as_it_is() -> None:
    given = recording(DATA)
    assert mended(given, NAMES).stretches == (given,)
    assert mended(given, NAMES).notes == ()


def test_nothing_but_gaps_is_refused_with_the_channel() -> None:
    lost = slow()
    lost[::20, 1] = np.nan
    with pytest.raises(InputError, match="no 32 samples in a row are whole, 19 at most; samples of a3 are lost"):
        mended(recording(lost), NAMES)


def read(folder: Path, data: FloatArray, dead_channels: bool = False) -> list[tuple[str, int]]:
    write_sample(folder)
    np.savez(folder / "r1.npz", data=data)
    dataset = load_dataset(folder / "dataset.toml", dead_channels)
    assert not any(np.isnan(each.data).any() for each in dataset.recordings)
    return [(each.name, each.data.shape[1]) for each in dataset.recordings]


def test_a_dataset_has_the_stretches_and_says_so(tmp_path: Path) -> None:
    data = DATA.copy()
    data[200:240, 0] = np.nan
    assert read(tmp_path, data) == [("r1 (1)", 200), ("r1 (2)", 160), ("r2", SAMPLES)]
    (note,) = load_dataset(tmp_path / "dataset.toml").notes
    assert note == "r1: samples 201 to 240 are lost (a2); each stretch between is a recording of its own"


def test_a_channel_that_is_lost_throughout_is_a_dead_one(tmp_path: Path) -> None:
    dead = broken(slice(None), 2, np.nan)
    with pytest.raises(InputError, match="channel 'd3' is constant"):
        read(tmp_path, dead)
    assert read(tmp_path, dead, dead_channels=True) == [("r1", SAMPLES), ("r2", SAMPLES)]


def written(folder: Path, rows: list[str], key: str = "") -> Dataset:
    """The sample with its first recording from rows of time, channels and force; the force is a load with ``key``."""
    write_sample(folder)
    (folder / "r1.csv").write_text("\n".join(["time,a2,a3,d3,force", *rows]))
    load = f'loads = [{{ node = 3, direction = "x", file = "r1.csv", key = "{key}" }}]\n' if key else ""
    (folder / "dataset.toml").write_text(TOML.replace('"r1.npz"\nkey = "data"\n', f'"r1.csv"\n{load}'))
    return load_dataset(folder / "dataset.toml")


def rows_of(rate: float = 100.0) -> list[str]:
    return [",".join(f"{value:.9f}" for value in (n / rate, *row, n)) for n, row in enumerate(DATA)]


def test_rows_that_are_missing_by_their_times_are_gaps_of_the_load_as_well(tmp_path: Path) -> None:
    rows = rows_of()
    dataset = written(tmp_path, [*rows[:150], *rows[170:300], *rows[301:]], "force")
    parts = dataset.recordings[:-1]
    assert [(part.name, part.data.shape[1], part.skipped) for part in parts] == [
        ("r1 (1)", 150, 0),
        ("r1 (2)", 130, 170),
        ("r1 (3)", 99, 301),
    ]
    for part in parts:
        np.testing.assert_allclose(part.loads[0].values, part.skipped + np.arange(part.data.shape[1]))
    assert any("samples 151 to 170, 301 to 301 are lost (a2, a3, d3)" in note for note in dataset.notes)


def test_a_wrong_rate_is_named_beside_missing_rows_and_a_clock_that_goes_back_is_refused(tmp_path: Path) -> None:
    rows = rows_of(50.0)
    with pytest.raises(InputError, match=r"has a step of 0\.02 s \(50 Hz\), but sampling_rate says 100 Hz"):
        written(tmp_path, [*rows[:150], *rows[170:]])
    rows = rows_of()
    with pytest.raises(InputError, match=r"jumps from 1\.99 to 0 s"):
        written(tmp_path, [*rows[:200], *rows[:200]])


def test_empty_cells_of_a_table_are_gaps(tmp_path: Path) -> None:
    write_sample(tmp_path)
    rows = [",".join(f"{value:.9f}" for value in (number / 100, *row)) for number, row in enumerate(DATA)]
    rows[200:240] = 40 * [",,,"]
    (tmp_path / "r1.csv").write_text("\n".join(["time,a2,a3,d3", *rows, ",,,"]))
    (tmp_path / "dataset.toml").write_text(TOML.replace('"r1.npz"\nkey = "data"', '"r1.csv"'))
    names = [each.name for each in load_dataset(tmp_path / "dataset.toml").recordings]
    assert names == ["r1 (1)", "r1 (2)", "r2"]
