"""Text files as loggers and spreadsheets write them: separators, decimal commas, units, lines above."""

from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.files import size_limit, text_table
from fe_models.files.dataset_file import load_dataset
from fe_models.files.named_columns import converting_factor
from fe_models.files.text_table import open_table
from fe_models.files.unit_words import known_unit, name_and_unit
from fe_models.recordings import Dataset
from tests.sample_dataset import NAMES, RATE, SAMPLES, TOML, free_decay, write_sample

DATA = np.round(free_decay(1), 9)
TIME = np.arange(SAMPLES) / RATE
G = 9.80665  # m/s^2


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_sample(tmp_path)


def rows_of(columns: list[FloatArray], mark: str = ",", decimal: str = ".") -> str:
    rows = zip(*columns, strict=True)
    return "\n".join(mark.join(f"{value:.9f}".replace(".", decimal) for value in row) for row in rows) + "\n"


def loaded(folder: Path, text: str, suffix: str = "csv", encoding: str = "utf-8") -> Dataset:
    """The sample dataset, its first recording read from a text."""
    (folder / f"r1.{suffix}").write_text(text, encoding=encoding)
    (folder / "dataset.toml").write_text(TOML.replace('"r1.npz"\nkey = "data"', f'"r1.{suffix}"'))
    return load_dataset(folder / "dataset.toml")


@pytest.mark.parametrize("mark", [",", ";", "\t", "   "])
@pytest.mark.parametrize("decimal", [".", ","])
@pytest.mark.parametrize("units", [None, ("s", "g", "m/s²", "mm"), ("[ms]", "[m/s^2]", "[g]", "[-]")])
def test_layouts_are_guessed_and_units_converted(
    folder: Path, mark: str, decimal: str, units: tuple[str, ...] | None
) -> None:
    if decimal == mark:
        return
    factors = {"g": 1 / G, "[g]": 1 / G, "[ms]": 1000.0}
    columns = [TIME, *DATA.T]
    names = mark.join(("Time", *NAMES)) + "\n"
    if units is not None:
        columns = [factors.get(unit, 1.0) * column for unit, column in zip(units, columns, strict=True)]
        names += mark.join(units) + "\n"
    dataset = loaded(folder, names + rows_of(columns, mark, decimal), "txt")
    np.testing.assert_allclose(dataset.recordings[0].data[0], DATA, atol=1e-8)  # nine decimals, of g
    words = {";": "semicolons", "\t": "tabs", "   ": "spaces"}
    notes = " ".join(dataset.notes)
    assert ("separated by" in notes) == (mark != ",") and words.get(mark, "") in notes
    assert ("with decimal commas" in notes) == (decimal == ",")
    assert ("with units below the names" in notes) == (units is not None)


def test_a_unit_behind_the_name_is_the_column_s(folder: Path) -> None:
    text = "Time [ms],a2 [g],a3 (m/s2),d3\n" + rows_of([1000 * TIME, DATA[:, 0] / G, *DATA.T[1:]])
    dataset = loaded(folder, text)
    np.testing.assert_allclose(dataset.recordings[0].data[0], DATA, atol=1e-8)
    assert "r1.csv: a2: converted from g, which the file states, to m/s^2" in dataset.notes


def test_a_unit_of_another_quantity_is_refused(folder: Path) -> None:
    with pytest.raises(InputError, match="column 'a2' is in mm, which is no m/s\\^2: name another"):
        loaded(folder, "a2,a3,d3\nmm,g,-\n" + rows_of(list(DATA.T)))


@pytest.mark.parametrize(
    ("form", "mark"),
    [("%Y-%m-%dT%H:%M:%S.%f", ","), ("%Y-%m-%d %H:%M:%S.%f", ";"), ("%H:%M:%S.%f", ","), ("%d.%m.%Y %H:%M:%S.%f", ";")],
)
def test_the_times_of_a_clock_are_a_column_of_times(folder: Path, form: str, mark: str) -> None:
    start = datetime(2024, 5, 1, 9, 59, 58)
    for rate in (RATE, 200.0):
        times = [(start + timedelta(seconds=n / rate)).strftime(form) for n in range(SAMPLES)]
        rows = rows_of(list(DATA.T), mark, "," if mark == ";" else ".").splitlines()
        text = "\n".join(
            [mark.join(("Timestamp", *NAMES)), *(mark.join(pair) for pair in zip(times, rows, strict=True))]
        )
        if rate == RATE:
            np.testing.assert_allclose(loaded(folder, text).recordings[0].data[0], DATA, atol=1e-9)
            continue
        with pytest.raises(InputError, match=r"'Timestamp' has a step of 0\.005 s \(200 Hz\)"):
            loaded(folder, text)


def test_a_load_s_unit_is_converted_to_newtons(folder: Path) -> None:
    (folder / "pull.csv").write_text("time,pull\ns,kN\n" + rows_of([TIME, TIME]))
    text = TOML.replace('file = "r2.npz", key = "force"', 'file = "pull.csv", key = "pull"')
    (folder / "dataset.toml").write_text(text)
    np.testing.assert_allclose(load_dataset(folder / "dataset.toml").recordings[1].loads[0].values, 1000 * TIME)


def test_what_stands_above_the_header_is_skipped(folder: Path) -> None:
    above = "Logger 7;bridge south\nDate;2024-05-01;10:00:00\n\nComment;windy, and cold\n"
    dataset = loaded(folder, above + ";".join(NAMES) + "\n" + rows_of(list(DATA.T), ";"))
    np.testing.assert_allclose(dataset.recordings[0].data[0], DATA, atol=1e-9)
    assert "with lines of comment, which are skipped" in dataset.notes[0]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_texts_of_windows_programs_are_read(folder: Path, encoding: str) -> None:
    text = "a2;a3;d3;Temperatur\nm/s²;m/s²;-;°C\n" + rows_of([*DATA.T, TIME], ";", ",")
    dataset = loaded(folder, text, encoding=encoding)
    np.testing.assert_allclose(dataset.recordings[0].data[0], DATA, atol=1e-9)
    assert ("in cp1252" in dataset.notes[0]) == (encoding == "cp1252")


def test_quotation_marks_may_hold_a_separator(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text('"left, top",b,c\n"1","2",ok\n3,4,"not, so"\n')
    table = open_table(tmp_path / "a.csv")
    assert table.header == ["left, top", "b", "c"]
    np.testing.assert_array_equal(table.numbers([1, 0]), [[2.0, 1.0], [4.0, 3.0]])


def test_a_lost_sample_is_none(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("a,b\n1,2\n,4\nNaN,6\n,\n7,n/a\n8,9\n,\n")
    nan = np.nan
    table = open_table(tmp_path / "a.csv")
    np.testing.assert_array_equal(table.numbers([0, 1]), [[1, 2], [nan, 4], [nan, 6], [nan, nan], [7, nan], [8, 9]])


def test_both_ways_of_reading_give_the_same(tmp_path: Path) -> None:
    """A lost sample at the end sends the whole file the longer way."""
    plain = "a;b;c\n" + rows_of(list(DATA.T), ";", ",")
    (tmp_path / "a.csv").write_text(plain)
    (tmp_path / "b.csv").write_text(plain + ";1;1\n")
    short, long = (open_table(tmp_path / name).numbers([2, 0]) for name in ("a.csv", "b.csv"))
    np.testing.assert_array_equal(long[:-1], short)


@pytest.mark.parametrize("lost", ["", "x"])
def test_more_numbers_than_the_limit_are_refused_while_they_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lost: str
) -> None:
    (tmp_path / "a.csv").write_text("a,b\n" + 100 * "1,2\n" + f"1,{lost}\n")
    monkeypatch.setattr(text_table, "CHUNK", 10)
    monkeypatch.setattr(size_limit, "MAX_VALUES", 50)
    with pytest.raises(InputError, match="numbers, and at most 50 are read"):
        open_table(tmp_path / "a.csv").numbers([0, 1])


@pytest.mark.parametrize(
    ("word", "factor", "si"),
    [("g", G, "m/s^2"), ("[M/S2]", 1.0, "m/s^2"), ("m/sec^2", 1.0, "m/s^2"), ("µm", 1e-6, "m"), ("MM", 1e-3, "m"),
     ("kN·m", 1e3, "N m"), ("mN", 1e-3, "N"), ("MN", 1e6, "N"), ("°/s", np.pi / 180, "rad/s")],
)  # fmt: skip
def test_units_however_they_are_written(word: str, factor: float, si: str) -> None:
    found = known_unit(word)
    assert found is not None
    assert found.si == si
    assert found.factor == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize("word", ["", "V", "-", "kn", "left", "1"])
def test_other_words_are_no_units(word: str) -> None:
    assert known_unit(word) is None
    assert converting_factor("a", word, "m/s^2") == 1.0


def test_brackets_behind_a_name_are_a_unit_only_if_they_hold_one() -> None:
    assert name_and_unit("A1 [g]") == ("A1", "g")
    assert name_and_unit("A1 (left)") == ("A1 (left)", "")
