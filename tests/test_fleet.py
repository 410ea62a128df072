"""Fleets of diagnoses: which datasets, what is kept and done again, the table of all answers, the command."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fe_models.errors import InputError
from fe_models.files.run_guard import guarded, lock_folder
from hybrid.commands.app import app
from hybrid.fleet.case import Case, Told, case_of, diagnosed_case
from hybrid.fleet.datasets import dataset_files, is_fleet, names_of
from hybrid.fleet.diagnosed_file import Options
from hybrid.fleet.engine import Answers
from hybrid.fleet.rows import Row, kept_rows
from hybrid.fleet.run import CHANGED, run_fleet
from hybrid.fleet.table import content, in_terminal, page
from hybrid.report.rendering import rendered
from hybrid.result_sets import REPORT
from tests.pages import Reader
from tests.sample_dataset import write_sample

TOLD = Told("explained", "Explained", "found", "A spring is softer.", 0.97, 0.2, 0.01, 0.01, 4.0)
PLAIN = Options()


class Given:
    """An answer that is there."""

    def __init__(self, value: Told | tuple[str, ...] | Exception) -> None:
        self.value = value

    def result(self) -> Told | tuple[str, ...]:
        if isinstance(self.value, Exception):
            raise self.value
        return self.value


def sample(folder: Path) -> Path:
    folder.mkdir(parents=True)
    write_sample(folder)
    return folder / "dataset.toml"


# Of which datasets


def test_a_folder_stands_for_the_datasets_in_it_and_below_it(tmp_path: Path) -> None:
    first, second = sample(tmp_path / "bridges" / "north"), sample(tmp_path / "bridges" / "south" / "2026")
    (tmp_path / "bridges" / "broken.toml").write_text("schema = ")
    sample(tmp_path / "bridges" / ".hidden")
    out = tmp_path / "bridges" / "results"
    sample(out / "north")
    assert is_fleet([tmp_path / "bridges"])
    found = dataset_files([tmp_path / "bridges", first], out)  # first once; no structure files
    assert found == [tmp_path / "bridges" / "broken.toml", first, second]
    assert names_of(found) == ["broken", "north", "2026"]


def test_faults_of_all_paths_are_told_at_once(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError) as caught:
        dataset_files([tmp_path / "none.toml", tmp_path / "empty"], tmp_path / "out")
    assert [fault.split(": ")[1].split(" (")[0] for fault in caught.value.faults] == [
        "no such file or folder",
        "no dataset in this folder or those within it; a dataset file names sensors",
    ]


def test_names_tell_all_files_apart_and_change_for_nobody_else(tmp_path: Path) -> None:
    files = [Path("/data") / name for name in ("a/dataset.toml", "b/x.toml", "c/x.toml", "d/e.toml")]
    assert names_of(files) == ["a", "b-x", "c-x", "e"]
    assert names_of([*files, Path("/other/y.toml")]) == ["a", "b-x", "c-x", "e", "y"]
    alike = [Path("/a-b/c.toml"), Path("/z/a/b-c.toml"), Path("/z/a-b-c/dataset.toml")]
    assert len(set(names_of(alike))) == 3


# What is done, and what again


def fleet(tmp_path: Path, count: int = 3) -> tuple[list[Case], Path]:
    out = tmp_path / "out"
    files = [sample(tmp_path / f"s{number}") for number in range(count)]
    return [case_of(file.parent.name, file, out, PLAIN) for file in files], out


def answering(asked: list[str], failing: str = "", fault: object = ("no sensor",)):  # type: ignore[no-untyped-def]
    """Return what answers each case, but the one that fails, and notes which it was asked for."""

    def answers(cases: Iterator[Case]) -> Answers[Case, Told | tuple[str, ...]]:
        for case in cases:
            asked.append(case.name)
            if case.name == failing:
                yield case, Given(fault)  # type: ignore[arg-type]
                continue
            Path(case.out).mkdir(parents=True, exist_ok=True)
            (Path(case.out) / REPORT).write_text("{}")
            yield case, Given(TOLD)

    return answers


def test_what_is_diagnosed_is_not_diagnosed_again(tmp_path: Path) -> None:
    cases, out = fleet(tmp_path)
    asked: list[str] = []
    heard: list[tuple[int, int]] = []
    rows = run_fleet(cases, out, answering(asked), lambda *own: heard.append(own))
    assert asked == ["s0", "s1", "s2"]
    assert heard == [(done, 3) for done in range(4)]
    again = run_fleet(cases, out, answering(asked), lambda *own: heard.append(own))
    assert (asked, again, heard[-1]) == (["s0", "s1", "s2"], rows, (3, 3))


def test_changed_inputs_and_options_and_lost_reports_are_done_anew(tmp_path: Path) -> None:
    cases, out = fleet(tmp_path)
    asked: list[str] = []
    run_fleet(cases, out, answering(asked))
    model = tmp_path / "s0" / "mast.toml"  # which the dataset names
    model.write_text(model.read_text() + "\n")
    (Path(cases[1].out) / REPORT).unlink()
    now = [case_of(case.name, Path(case.file), out, PLAIN) for case in cases]
    assert [case.digest == old.digest for case, old in zip(now, cases, strict=True)] == [False, True, True]
    run_fleet(now, out, answering(asked))
    assert asked[3:] == ["s0", "s1"]
    by_modes = [case_of(case.name, Path(case.file), out, Options(by_modes=True)) for case in cases]
    assert kept_rows(out, by_modes) == {}


@pytest.mark.parametrize("fault", [("no sensor", "no model"), RuntimeError("of its own")])
def test_one_that_fails_stops_no_other_and_is_tried_again(tmp_path: Path, fault: object) -> None:
    cases, out = fleet(tmp_path)
    asked: list[str] = []
    rows = run_fleet(cases, out, answering(asked, "s1", fault))
    assert [row is not None and row.told is not None for row in rows] == [True, False, True]
    told = rows[1].faults if rows[1] is not None else ()
    assert told == (fault if isinstance(fault, tuple) else ("RuntimeError: of its own",))
    run_fleet(cases, out, answering(asked))
    assert asked == ["s0", "s1", "s2", "s1"]


def test_a_file_that_changes_meanwhile_gives_no_answer(tmp_path: Path) -> None:
    (case,), out = fleet(tmp_path, 1)

    def answers(cases: Iterator[Case]) -> Answers[Case, Told | tuple[str, ...]]:
        for own in cases:
            Path(own.file).write_text(Path(own.file).read_text() + "# edited\n")
            yield own, Given(TOLD)

    (row,) = run_fleet([case], out, answers)
    assert row is not None
    assert (row.told, row.faults) == (None, (CHANGED,))


def test_what_is_at_hand_is_on_the_page_when_a_run_breaks_off(tmp_path: Path) -> None:
    cases, out = fleet(tmp_path)

    def answers(cases: Iterator[Case]) -> Answers[Case, Told | tuple[str, ...]]:
        yield next(cases), Given(TOLD)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_fleet(cases, out, answers)
    table = json.loads((out / "fleet.json").read_text())
    assert [own["state"] for own in table["cases"]] == ["diagnosed", "not_yet", "not_yet"]


def test_a_damaged_row_is_made_again(tmp_path: Path) -> None:
    cases, out = fleet(tmp_path, 1)
    asked: list[str] = []
    run_fleet(cases, out, answering(asked))
    for text in ("{", "[]", '{"schema": 1, "name": 3}'):
        (out / ".fleet" / "s0.json").write_text(text)
        run_fleet(cases, out, answering(asked))
    assert asked == ["s0"] * 4


# One dataset as a task


def test_faults_of_an_input_are_what_a_task_returns(tmp_path: Path) -> None:
    file = sample(tmp_path / "s")
    file.write_text(file.read_text().replace("sampling_rate = 100.0", "sampling_rate = -1.0"))
    faults = diagnosed_case(case_of("s", file, tmp_path / "out", PLAIN))
    assert isinstance(faults, tuple)
    assert any("sampling_rate" in fault for fault in faults)


# The table


def rows() -> list[tuple[str, Row | None]]:
    fine = replace(TOLD, verdict="nothing_wrong", words="Nothing is wrong", sentence="Nothing.", probability=None)
    return [
        ("fine", Row("fine", "/d/fine.toml", "a", replace(fine, before=0.01, after=0.0101))),
        ("soft & <b>", Row("soft & <b>", "/d/soft.toml", "b", TOLD)),
        ("bad", Row("bad", "/d/bad.toml", "c", None, ("sensors[1].node: expected 1 to 3, found 9",))),
        ("later", None),
    ]


def test_the_page_has_a_row_each_with_its_report_and_what_asks_for_most_first() -> None:
    html = rendered(page(rows()))
    assert Reader(html).elements
    assert [html.index(word) for word in ("9</td>", "A spring is softer", "Nothing.")] == sorted(
        html.index(word) for word in ("9</td>", "A spring is softer", "Nothing.")
    )
    assert '<a href="soft%20%26%20%3Cb%3E/report.html">soft &amp; &lt;b&gt;</a>' in html
    assert "<b>soft" not in html and "& <b>" not in html
    assert 'data-value="0.97">97 %' in html
    assert 'data-value="0.95">95 %' in html  # the gain, 1 - 0.01 / 0.2
    assert "2 of 4 datasets are diagnosed, 1 could not be." in html
    assert "Not diagnosed yet" in html
    assert html.count("<a href") == 4  # two reports, two sections


def test_the_table_is_there_for_programs_and_terminals() -> None:
    table = content(rows())
    assert json.loads(json.dumps(table, allow_nan=False)) == table
    assert (table["planned"], table["diagnosed"]) == (4, 2)
    assert table["cases"][1]["gain"] == pytest.approx(0.95)
    assert table["cases"][2]["faults"] == ["sensors[1].node: expected 1 to 3, found 9"]
    change = replace(TOLD, after=0.21, change_gain=0.9)  # in one recording of many, the others are forecast as before
    assert Row("change", "/d/change.toml", "e", change).gain == 0.9
    lines = in_terminal(rows(), 60).splitlines()
    assert len(lines) == 5 and max(map(len, lines)) <= 60
    assert lines[2].split("  ")[0].rstrip() == "soft & <b>"
    assert "0.97" in lines[2] and "95 %" in lines[2]
    assert "error: sensors[1]" in lines[3]


# The command


def test_one_dataset_takes_no_options_of_fleets(tmp_path: Path) -> None:
    file = sample(tmp_path / "s")
    ran = CliRunner().invoke(app, ["diagnose", str(file), "--out", str(tmp_path / "o"), "--jobs", "2"])
    assert (ran.exit_code, ran.stderr) == (
        2,
        "error: --jobs has no effect on one dataset: it goes with several, or a folder of them\n",
    )


def test_two_runs_into_one_folder_are_refused(tmp_path: Path) -> None:
    sample(tmp_path / "a"), sample(tmp_path / "b")
    with guarded():
        lock_folder(tmp_path / "out")
        ran = CliRunner().invoke(app, ["diagnose", str(tmp_path), "--out", str(tmp_path / "out")])
    assert ran.exit_code == 2
    assert "another run writes into this folder now; wait for its end" in ran.stderr


def test_a_file_of_the_user_is_not_written_over(tmp_path: Path) -> None:
    sample(tmp_path / "a")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "fleet.html").write_text("mine")
    ran = CliRunner().invoke(app, ["diagnose", str(tmp_path), "--out", str(tmp_path / "out")])
    assert ran.exit_code == 2
    assert "fleet.html would be replaced" in ran.stderr


@pytest.mark.parametrize("name", ["--by-modes", "--modes"])
def test_the_search_by_modes_is_asked_for_by_its_name_and_by_the_older_one(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Options] = []

    def diagnose_fleet(paths: object, out: object, options: Options, *others: object) -> int:
        asked.append(options)
        return 0

    monkeypatch.setattr("hybrid.commands.fleet.diagnose_fleet", diagnose_fleet)
    folder = sample(tmp_path / "own").parent
    result = CliRunner().invoke(app, ["diagnose", str(folder), name, "--out", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    assert [own.words for own in asked] == [["--by-modes"]]
