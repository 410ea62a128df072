"""Recordings from .npz, .mat and .csv: read alike, and refused where they are broken, dead or wrongly sampled."""

from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat
from scipy.signal import butter, sosfilt

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset
from fe_models.files.recording_checks import energy_above
from fe_models.recordings import Dataset
from tests.sample_dataset import NAMES, RATE, SAMPLES, TOML, assert_fault, broken, faults_of, free_decay, write_sample


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_sample(tmp_path)


@pytest.mark.parametrize("step", [0.0, -0.01, np.inf])
def test_a_time_step_that_is_none_is_told(folder: Path, step: float) -> None:
    data = free_decay(1)
    savemat(folder / "r1.mat", {**{name: data[:, k] for k, name in enumerate(NAMES)}, "dt": step})
    faults = faults_of(folder, ('"r1.npz"\nkey = "data"', '"r1.mat"'))
    assert_fault(faults, f"r1.mat: its dt is {step:g} s; expected the time step, above 0 s, or none")


def test_mat_and_csv_recordings_read_like_npz(folder: Path) -> None:
    data = free_decay(1)
    savemat(folder / "r1.mat", {"acc": data, "dt": 0.01})
    header = "time,d3,a2,a3"  # in an order of its own, with a time column
    table = np.column_stack([np.arange(SAMPLES) / RATE, data[:, [2, 0, 1]]])
    np.savetxt(folder / "r1.csv", table, delimiter=",", header=header, comments="", fmt="%.17g")
    for old, new in (('"r1.npz"\nkey = "data"', '"r1.mat"\nkey = "acc"'), ('"r1.npz"\nkey = "data"', '"r1.csv"')):
        (folder / "dataset.toml").write_text(TOML.replace(old, new))
        np.testing.assert_array_equal(load_dataset(folder / "dataset.toml").recordings[0].data, data[None])


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        (broken(slice(9, 12), 0, np.inf), "channel 'a2': 3 samples are infinite, the first is number 10"),
        (broken(slice(None), 2, 4.0), "channel 'd3' is constant (4): a dead sensor?"),
        (np.stack([free_decay(1), broken(slice(None), 2, 0.0)]), "is constant (0) (of recording 2 in this array)"),
        (free_decay(1)[:31], "only 31 samples; at least 32 are needed"),
        (free_decay(1)[:, :2], "2 columns for 3 sensors; one column a sensor"),
        (free_decay(1).T, "400 columns for 3 sensors; one column a sensor; it looks transposed"),
        (free_decay(1)[:, 0], "shape (400,); expected (time, sensor) or (recording, time, sensor)"),
        (np.zeros((0, SAMPLES, 3)), "holds no recording at all"),
        (free_decay(1) > 0, "array 'data' holds bool, not real numbers"),
    ],
)
def test_a_fault_of_the_data_is_named(folder: Path, data: FloatArray, fault: str) -> None:
    np.savez(folder / "r1.npz", data=data)
    faults = faults_of(folder)
    assert_fault(faults, fault)
    assert all(line.startswith("dataset.toml: recordings[1] (r1): ") for line in faults)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("a2,zz,a3\n1,2,3\n3,4,5\n", "there is no column for sensor 'd3'; it has 'a2', 'zz', 'a3'"),
        ("a2,a3,d3,a3\n1,2,3,4\n", "column 'a3' appears twice"),
        ("a2,a3,d3\n1,2,3\n1,2\n", "line 3 has 2 values, the header 3"),
        ("a2,a3,d3\n1,2,x\n", "line 2: 'x' is not a number"),
        ("a2,a3,d3\n1,2,x\n3,4,5\n4,y,5\n", "line 4: 'y' is not a number"),
        ("a2,a3,d3\n" + 7 * "1,2\n", "and 2 more of that kind"),
        ("a2,a3,d3,\n1,2,3\n4,5,6,7\n", "line 3 has 4 values, the header 3"),  # the last column holds something
        ("a2,a3,d3\n", "expected a header line and rows of numbers, found 1 lines"),
        (
            "time,a2,a3,d3\n0,1,2,3\n0.1,1,2,3\n",
            "its column 'time' has a step of 0.1 s (10 Hz), but sampling_rate says 100 Hz",
        ),
        ("a2;a3;d3\n0,1;0,2;1.234,5\n", "line 2: '0,1' is not a number"),  # with points, commas may part thousands
        ("# by a logger\n0.1,0.2,0.3\n0.1,0.2,0.3\n", "line 2 holds numbers; expected a header line"),
        ("0.1,-2e-3,0.3\n0.1,0.2,0.3\n", "line 1 holds numbers; expected a header line with a name for each column"),
    ],
)
def test_a_fault_of_a_csv_is_named(folder: Path, text: str, fault: str) -> None:
    (folder / "r1.csv").write_text(text)
    assert_fault(faults_of(folder, ('"r1.npz"\nkey = "data"', '"r1.csv"')), fault)


@pytest.mark.parametrize(
    ("mark", "decimal", "form"),
    [
        (";", ",", "separated by semicolons, with decimal commas"),
        (";", ".", "separated by semicolons"),
        ("\t", ".", "separated by tabs"),
        ("\t", ",", "separated by tabs, with decimal commas"),
        (",", ".", ""),
    ],
)
@pytest.mark.parametrize("comment", ["", "# logger 7, channels 1 to 3\n"])
def test_files_of_spreadsheets_and_loggers_are_read_and_a_note_says_how(
    folder: Path, mark: str, decimal: str, form: str, comment: str
) -> None:
    plain = loaded(folder, csv_of({})).recordings[0].data
    dataset = loaded(folder, comment + csv_of({}).replace(",", mark).replace(".", decimal))
    np.testing.assert_array_equal(dataset.recordings[0].data, plain)
    words = [word for word in (form, "with lines of comment, which are skipped" if comment else "") if word]
    assert list(dataset.notes) == ([f"r1.csv: read as a file {', '.join(words)}"] if words else [])


def csv_of(columns: dict[str, FloatArray], end: str = "") -> str:
    """A recording of the three sensors beside other ``columns`` (sample,), each line with an ``end`` of its own."""
    table = {**columns, **dict(zip(NAMES, free_decay(1).T, strict=True))}
    rows = [",".join(f"{value:.6g}" for value in row) + end for row in zip(*table.values(), strict=False)]
    return "\n".join([",".join(table) + end, *rows])


def loaded(folder: Path, text: str) -> Dataset:
    """The sample dataset, its first recording read from a .csv file with that ``text``."""
    (folder / "r1.csv").write_text(text)
    (folder / "dataset.toml").write_text(TOML.replace('"r1.npz"\nkey = "data"', '"r1.csv"'))
    return load_dataset(folder / "dataset.toml")


@pytest.mark.parametrize("end", [",", ",,,", " , "])
def test_empty_columns_and_rows_at_the_end_of_a_csv_are_none(folder: Path, end: str) -> None:
    whole = loaded(folder, csv_of({}))
    header, *rows = csv_of({}).splitlines()
    for text in (csv_of({}, end), csv_of({}, end) + f"\n,,{end}\n", "\n".join([header, *(row + end for row in rows)])):
        found = loaded(folder, text)
        assert found.notes == ()
        np.testing.assert_array_equal(found.recordings[0].data, whole.recordings[0].data)


def test_columns_that_nobody_asks_for_are_skipped_and_said(folder: Path) -> None:
    """Whatever they hold: an index, words, a clock's date."""
    header, *rows = csv_of({}).splitlines()
    text = "\n".join([f",{header},status", *(f"{number},{row},ok" for number, row in enumerate(rows))])
    found = loaded(folder, text)
    whole = loaded(folder, csv_of({}))
    np.testing.assert_array_equal(found.recordings[0].data, whole.recordings[0].data)
    expected = "r1.csv: columns one without a name, 'status' belong to no sensor and no load and are skipped"
    assert found.notes == (expected,)
    assert whole.notes == ()


def test_a_load_may_be_a_column_of_the_recording_s_own_csv(folder: Path) -> None:
    force = np.sin(np.arange(float(SAMPLES)))
    (folder / "r2.csv").write_text(
        csv_of({"time": np.arange(SAMPLES) / RATE, "force": force, "temperature": 20 + force})
    )
    one = '"r2.npz"\nkey = "data"', '"r2.csv"'
    text = TOML.replace(*one).replace('file = "r2.npz", key = "force"', 'file = "r2.csv", key = "force"')
    (folder / "dataset.toml").write_text(text)
    found = load_dataset(folder / "dataset.toml")
    np.testing.assert_allclose(found.recordings[1].loads[0].values, force, rtol=1e-5)  # six digits are written
    assert found.notes == ("r2.csv: column 'temperature' belongs to no sensor and no load and is skipped",)
    (folder / "dataset.toml").write_text(text.replace('key = "force" }', 'key = "pull" }'))
    with pytest.raises(InputError, match=r"there is no column 'pull'; it has 'time', 'force', 'temperature', 'a2'"):
        load_dataset(folder / "dataset.toml")


def test_a_load_s_own_csv_needs_no_name_for_its_one_column_beside_times(folder: Path) -> None:
    rows = "\n".join(f"{number / RATE},{number % 3},done" for number in range(SAMPLES))
    for header, fault in (("time,pull,note", "has the columns 'pull', 'note'; say which with key"), ("time,pull", "")):
        (folder / "pull.csv").write_text(f"{header}\n{rows if fault else rows.replace(',done', '')}")
        changes = ('file = "r2.npz", key = "force"', 'file = "pull.csv"')
        if fault:
            assert_fault(faults_of(folder, changes), fault)
        else:
            (folder / "dataset.toml").write_text(TOML.replace(*changes))
            load = load_dataset(folder / "dataset.toml").recordings[1].loads[0]
            np.testing.assert_array_equal(load.values, np.arange(SAMPLES) % 3)


@pytest.mark.parametrize("name", ["time", "Time", "t", "Time (s)"])
def test_times_are_checked_whatever_the_logger_calls_them(folder: Path, name: str) -> None:
    assert loaded(folder, csv_of({name: np.arange(SAMPLES) / RATE})).notes == ()
    (folder / "r1.csv").write_text(csv_of({name: np.arange(SAMPLES) / 200.0}))
    faults = faults_of(folder, ('"r1.npz"\nkey = "data"', '"r1.csv"'))
    assert_fault(faults, f"r1.csv: its column {name!r} has a step of 0.005 s (200 Hz), but sampling_rate says 100 Hz")


def test_a_time_step_that_contradicts_the_sampling_rate_is_named(folder: Path) -> None:
    savemat(folder / "r1.mat", {"acc": free_decay(1), "dt": 0.02})
    faults = faults_of(folder, ('"r1.npz"\nkey = "data"', '"r1.mat"\nkey = "acc"'))
    assert_fault(faults, "r1.mat: its dt is 0.02 s (50 Hz), but sampling_rate says 100 Hz")


@pytest.mark.parametrize(("rate", "right"), [(29.97, True), (29.4, True), (33.0, False)])
def test_a_stored_time_step_may_be_rounded_to_two_digits(folder: Path, rate: float, right: bool) -> None:
    """0.034 s is how whole milliseconds write 29.4 Hz; for 33 Hz they would say 0.030 s."""
    savemat(folder / "r1.mat", {"acc": free_decay(1), "dt": 0.033 if rate == 29.97 else 0.034})
    text = TOML.replace('"r1.npz"\nkey = "data"', '"r1.mat"\nkey = "acc"').replace("lowpass = 30.0\n", "")
    (folder / "dataset.toml").write_text(text.replace("sampling_rate = 100.0", f"sampling_rate = {rate}"))
    with nullcontext() if right else pytest.raises(InputError, match=r"its dt is 0\.034 s"):
        load_dataset(folder / "dataset.toml")


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 truncated", b"\x80\x04pickle", b"MATLAB 5.0 MAT-file, nothing"])
@pytest.mark.parametrize("suffix", [".npz", ".mat", ".csv"])
def test_a_corrupt_file_is_bad_input(folder: Path, content: bytes, suffix: str) -> None:
    (folder / f"r1{suffix}").write_bytes(content)
    assert_fault(faults_of(folder, ("r1.npz", f"r1{suffix}")), f"r1{suffix}")


@pytest.mark.parametrize("suffix", [".npz", ".mat"])
@pytest.mark.parametrize("kept", [0.3, 0.6, 0.9])
def test_a_truncated_file_is_bad_input(folder: Path, suffix: str, kept: float) -> None:
    path = folder / f"r1{suffix}"
    if suffix == ".mat":
        savemat(path, {"data": free_decay(1)}, do_compression=True)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(kept * len(whole))])
    assert_fault(faults_of(folder, ("r1.npz", f"r1{suffix}")), f"r1{suffix}")


def test_energy_above_a_frequency_is_that_of_the_harmonics_there() -> None:
    time = np.arange(1000) / RATE
    signal = 2.0 + 3.0 * np.sin(2 * np.pi * 5 * time) + 1.0 * np.sin(2 * np.pi * 35 * time)
    # 1 / (9 + 1); both harmonics fall on frequency lines, so only the window's far side lobes differ.
    assert energy_above(signal, RATE, 20.0) == pytest.approx(0.1, rel=1e-6)


def test_noise_behind_a_free_decay_is_little_of_its_energy() -> None:
    """A window that hides the beginning leaves as much noise as motion; an abrupt end alone leaks upwards."""
    time = np.arange(1000) / RATE
    noise = 0.02 * np.random.default_rng(0).standard_normal(len(time))
    decay = np.exp(-0.05 * 2 * np.pi * 5 * time) * np.cos(2 * np.pi * 5 * time) + noise
    assert energy_above(decay, RATE, 20.0) < 0.03
    assert energy_above(np.sin(2 * np.pi * 0.35 * time[:-140]), RATE, 20.0) < 1e-6


def test_the_low_pass_check_takes_any_common_filter_and_finds_none(folder: Path) -> None:
    noise = np.random.default_rng(0).standard_normal((4000, 3))
    for order, lowpass in ((4, 5.0), (4, 30.0), (8, 30.0)):
        filtered = sosfilt(butter(order, lowpass, fs=RATE, output="sos"), noise, axis=0)
        np.savez(folder / "r1.npz", data=filtered)
        np.savez(folder / "r2.npz", data=-filtered, force=np.ones(4000))
        (folder / "dataset.toml").write_text(TOML.replace("lowpass = 30.0", f"lowpass = {lowpass}"))
        load_dataset(folder / "dataset.toml")
    np.savez(folder / "r1.npz", data=noise)  # 34 % of it lies above 33 Hz
    assert_fault(faults_of(folder), "34% of its energy lies well above the lowpass of 30 Hz")


@pytest.mark.parametrize(
    ("unit", "si", "factor"), [("g", "m/s^2", 9.80665), ("mm/s^2", "m/s^2", 1e-3), ("m/s^2", "m/s^2", 1.0)]
)
def test_units_beside_si_are_brought_to_si(folder: Path, unit: str, si: str, factor: float) -> None:
    plain = loaded(folder, csv_of({}))
    text = (folder / "dataset.toml").read_text()
    (folder / "dataset.toml").write_text(text.replace('"m/s^2"', f'"{unit}"'))
    dataset = load_dataset(folder / "dataset.toml")
    for sensor, before, after in zip(
        dataset.sensors, plain.recordings[0].data.T, dataset.recordings[0].data.T, strict=True
    ):
        accelerates = sensor.quantity == "acceleration"
        assert sensor.unit == (si if accelerates else "1")
        np.testing.assert_allclose(after, factor * before if accelerates else before, rtol=1e-14)


def test_a_unit_of_another_quantity_is_refused_with_those_that_fit(folder: Path) -> None:
    fault = 'unit \'g\' does not fit displacement in y; expected "m" (SI), or "1" if normalised; files may have "mm"'
    assert_fault(faults_of(folder, ('unit = "1"', 'unit = "g"')), fault)
