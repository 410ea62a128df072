"""The certificate: its plan, a run that is killed or breaks down, and the page. None of its own seeds is run here."""

import json
import signal
import subprocess
import sys
import time
from collections import Counter
from functools import partial
from math import inf
from pathlib import Path
from typing import get_args

import pytest
from typer.testing import CliRunner

from benchmarks.blind.cases import CERTIFICATE_SEED, Task, tasks
from benchmarks.blind.judging import Judgement
from benchmarks.blind.rates import Share
from benchmarks.blind_cases import BlindConfig, Excitation
from benchmarks.certificate import door
from benchmarks.certificate import run as running
from benchmarks.certificate.code import INSTALLED, Code, code_of
from benchmarks.certificate.counts import Certificate, certificate, content
from benchmarks.certificate.page import page
from benchmarks.certificate.plan import COLUMNS, Column, interleaved
from benchmarks.certificate.record import Record, keep, kept
from benchmarks.certificate.run import run, write
from fe_models.errors import InputError
from scripts.benchmark import app
from tests import certificate_work
from tests.blind_results import CUBIC, EXPLAINED, FINE, HEAVY, UNEXPLAINED, case_of, diagnosis, finding, result
from tests.certificate_work import CODE, FIRST, breaking, endless, right, slow

ROOT = Path(__file__).parents[1]


def of_code() -> Code:
    return CODE


# The plan


def test_seeds_are_the_certificates_alone() -> None:
    seeds = [task.seed for column in COLUMNS for task in column.tasks]
    assert len(seeds) == len(set(seeds)) == 1280
    assert min(seeds) >= CERTIFICATE_SEED
    assert tasks(1, CERTIFICATE_SEED - 1, ("nothing",), BlindConfig())[0].seed == CERTIFICATE_SEED - 1
    with pytest.raises(InputError, match="seeds from 20000000 on are for --certificate alone"):
        tasks(2, CERTIFICATE_SEED - 1, ("nothing",), BlindConfig())


def test_every_kind_is_hidden_as_often_as_another() -> None:
    for column in COLUMNS:
        counts, words = Counter(task.hidden for task in column.tasks), Counter(column.words)
        for word, times in words.items():  # "nothing" stands three times in each round
            assert counts[word] // times in (column.count // words.total(), -(-column.count // words.total()))
        assert {task.config for task in column.tasks} == {column.config}


def test_the_first_cases_of_a_run_stand_for_all_columns() -> None:
    order = interleaved(COLUMNS)
    assert len(order) == 1280
    first = Counter(task.config for task in order[:128])
    assert first == {column.config: column.count // 10 for column in COLUMNS}


def test_each_excitation_has_a_column_and_free_vibration_keeps_its_seeds() -> None:
    assert {column.excitation for column in COLUMNS} == set(get_args(Excitation))
    free = [column for column in COLUMNS if column.excitation == "free"][:4]
    assert [column.first_seed - CERTIFICATE_SEED for column in free] == [0, 100_000, 200_000, 300_000]
    # Since the hysteretic spring is on the list, and other forces are outside.
    first = ["coulomb_friction", "coulomb_friction", "hysteretic_spring", "axial_force"]
    assert [column.tasks[0].hidden for column in free] == first


# The run


@pytest.mark.slow
def test_a_case_whose_process_dies_or_raises_counts_as_wrong(tmp_path: Path) -> None:
    found = run(certificate_work.COLUMNS, tmp_path, jobs=2, code=of_code, work=breaking)
    exact, off = found.columns
    assert (exact.done, off.done) == (4, 2)
    assert exact.failures == {f"process ended ({-signal.SIGKILL})": 1, "MemoryError": 1}
    assert off.failures == {}
    wrong = {task.seed for task in interleaved(certificate_work.COLUMNS)[:3]} & {FIRST, FIRST + 1}
    assert wrong == {FIRST, FIRST + 1}
    assert sum(share.hits for share in exact.hidden.values()) == 2
    assert sum(share.count for share in exact.hidden.values()) == 4
    assert "process ended (-9) (1)" in page(found)


@pytest.mark.slow
def test_a_case_that_never_ends_counts_as_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "LIMIT", 3.0)
    found = run((Column("four_dof", "exact", 2, FIRST),), tmp_path, jobs=1, code=of_code, work=endless)
    assert found.columns[0].failures == {"TimeoutError": 1}
    assert found.columns[0].done == 2


@pytest.mark.slow
def test_a_run_that_is_killed_loses_the_cases_in_work_alone(tmp_path: Path) -> None:
    script = (
        "from pathlib import Path\n"
        "from tests.test_certificate import *\n"
        f"run(certificate_work.COLUMNS, Path({str(tmp_path)!r}), jobs=2, code=of_code, work=slow)"
    )
    begun = subprocess.Popen([sys.executable, "-c", script], cwd=ROOT)
    while not list(tmp_path.glob("cases/[0-9]*.json")):
        assert begun.poll() is None, "ended by itself"
        time.sleep(0.05)
    begun.kill()
    begun.wait()
    before = kept(tmp_path, interleaved(certificate_work.COLUMNS))
    assert 1 <= len(before) < 6
    heard: list[tuple[int, int]] = []
    found = run(
        certificate_work.COLUMNS,
        tmp_path,
        jobs=2,
        code=of_code,
        work=right,
        advance=lambda there, all_of: heard.append((there, all_of)),
    )
    assert heard == [(there, 6) for there in range(len(before), 7)]
    assert (found.done, found.planned) == (6, 6)


def test_a_run_out_of_time_begins_nothing_new_and_says_how_far_it_came(tmp_path: Path) -> None:
    found = run(certificate_work.COLUMNS, tmp_path, jobs=2, code=of_code, work=slow, minutes=1 / 6000)
    assert 0 <= found.done < 6
    assert f"Not complete: {found.done} of 6 cases so far" in page(found)
    assert run(certificate_work.COLUMNS, tmp_path, jobs=2, code=of_code, work=slow, minutes=0.0).done == found.done


def test_a_certificate_is_of_one_code(tmp_path: Path) -> None:
    few = (Column("four_dof", "exact", 1, FIRST),)
    with pytest.raises(InputError, match="not committed: commit or stash them, or give --dirty"):
        run(few, tmp_path, jobs=1, code=lambda: Code("a" * 40, "b" * 64), work=right)
    changed = run(few, tmp_path, jobs=1, code=lambda: Code("a" * 40, "b" * 64), work=right, changed=True)
    assert "**With changes that are not committed**" in page(changed)
    with pytest.raises(InputError, match="holds cases of commit aaaaaaaaaaaa with changes that are not committed; the"):
        run(few, tmp_path, jobs=1, code=of_code, work=right)
    with pytest.raises(InputError, match="holds cases of other columns"):
        run(
            (Column("four_dof", "off", 1, FIRST),),
            tmp_path,
            jobs=1,
            code=lambda: changed.code,
            work=right,
            changed=True,
        )


@pytest.mark.slow
def test_code_that_changes_while_it_runs_ends_the_run(tmp_path: Path) -> None:
    codes = iter([CODE, Code("f" * 40), Code("f" * 40)])
    with pytest.raises(InputError, match="the code changed while cases of commit 0123456789ab ran"):
        run((Column("four_dof", "exact", 1, FIRST),), tmp_path, jobs=1, code=lambda: next(codes), work=right)
    assert not list(tmp_path.glob("cases/*.json"))


@pytest.mark.slow
def test_a_diagnosis_is_counted_as_it_is_judged(tmp_path: Path) -> None:
    column = Column("four_dof", "exact", 2, FIRST)
    found = run((column,), tmp_path, jobs=2, code=of_code)
    records = kept(tmp_path, column.tasks)
    assert [record.failure for record in records.values()] == ["", ""]
    for task, record in records.items():
        assert record.judgement is not None
        assert [word.split(" ")[0] for word in record.judgement.truth] == [task.hidden]  # neither is a clean case
        assert 0.5 < record.judgement.over_floor < 1.5  # of a forecast that was really made
    assert found == certificate(CODE, (column,), records)


# What is kept


@pytest.mark.parametrize(
    "judgement",
    [
        result(case_of(CUBIC), diagnosis(EXPLAINED, finding(CUBIC, 0.99), finding(HEAVY, 0.4))).judgement,
        result(case_of(CUBIC), diagnosis(UNEXPLAINED, over_floor=inf)).judgement,
    ],
)
def test_a_judgement_comes_back_as_it_was(tmp_path: Path, judgement: Judgement) -> None:
    task, record = Task(FIRST, "cubic_spring", BlindConfig()), Record(judgement, "", "a machine", "2026-11-28")
    keep(tmp_path, task, record)
    assert kept(tmp_path, [task]) == {task: record}


def test_damaged_records_are_named_all_at_once(tmp_path: Path) -> None:
    wanted = tasks(3, FIRST, ("nothing",), BlindConfig())
    (tmp_path / "cases").mkdir()
    for task, text in zip(wanted, ("{", "[]", '{"judgement": {"truth": []}}'), strict=True):
        (tmp_path / "cases" / f"{task.seed}.json").write_text(text)
    with pytest.raises(InputError) as caught:
        kept(tmp_path, wanted)
    assert len(caught.value.faults) == 3
    assert all("delete it to have it made again" in fault for fault in caught.value.faults)


# The code


def git(folder: Path, *words: str) -> str:
    own = ["-c", "user.name=N", "-c", "user.email=n@n"]
    ran = subprocess.run(["git", *own, *words], cwd=folder, capture_output=True, text=True, check=True)
    return ran.stdout.strip()


def test_changes_of_the_product_are_seen_and_others_are_not(tmp_path: Path) -> None:
    git(tmp_path, "init", "--quiet")
    (tmp_path / "hybrid").mkdir()
    (tmp_path / "hybrid" / "own.py").write_text("one = 1\n")
    git(tmp_path, "add", ".")
    git(tmp_path, "commit", "--quiet", "--message", "one")
    committed = Code(git(tmp_path, "rev-parse", "HEAD"))
    assert code_of(tmp_path) == committed
    (tmp_path / "notes.md").write_text("a page that a certificate writes\n")
    (tmp_path / INSTALLED).parent.mkdir(parents=True)
    (tmp_path / INSTALLED).write_text("numbers that a certificate writes\n")
    assert code_of(tmp_path) == committed
    (tmp_path / "hybrid" / "new.py").write_text("two = 2\n")
    added = code_of(tmp_path).changes
    (tmp_path / "hybrid" / "new.py").write_text("two = 3\n")
    edited = code_of(tmp_path).changes
    (tmp_path / "hybrid" / "new.py").unlink()
    (tmp_path / "hybrid" / "own.py").write_text("one = 2\n")
    assert len({"", added, edited, code_of(tmp_path).changes}) == 4


def test_code_that_is_no_clone_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is no clone of the repository"):
        code_of(tmp_path)
    git(tmp_path, "init", "--quiet")
    git(tmp_path, "commit", "--quiet", "--allow-empty", "--message", "of another project")
    (tmp_path / "site-packages").mkdir()
    with pytest.raises(InputError, match="is no clone of the repository"):
        code_of(tmp_path / "site-packages")


# The page


def some_certificate() -> Certificate:
    """Of six cases one is wrong at 0.95, one has no report, and one is too weak for forecasts to need it."""
    exact, off = certificate_work.COLUMNS
    cubic = diagnosis(EXPLAINED, finding(CUBIC, 0.99))
    found = [
        diagnosis(FINE, over_floor=1.02),
        diagnosis(EXPLAINED, finding(HEAVY, 0.95), seconds=50.0),
        cubic,
        None,
        cubic,
        diagnosis(UNEXPLAINED, over_floor=1.3),
    ]
    records = {
        task: Record(
            None if own is None else result(case_of(CUBIC), own).judgement,
            "MemoryError" if own is None else "",
            "2 at a time on a machine",
            "2026-11-28",
        )
        for task, own in zip(exact.tasks + off.tasks, found, strict=True)
    }
    return certificate(CODE, (exact, off), {Task(t.seed, "cubic_spring", t.config): r for t, r in records.items()})


def test_the_page_has_every_rate_with_its_interval_and_no_single_case(monkeypatch: pytest.MonkeyPatch) -> None:
    hide_cubic_springs(monkeypatch)
    lines = page(some_certificate()).splitlines()
    rows = {line.split(" | ")[0].removeprefix("| "): line.split(" | ")[1:] for line in lines if line.startswith("| ")}
    assert rows["kind and place right, first"][:2] == ["25.0 % (1/4; 4.6 to 69.9)", ">= 99 %"]
    assert rows["the same, of causes that forecasts need"][0].startswith("33.3 % (1/3;")
    assert rows["wrong name at >= 0.9"][0].startswith("25.0 % (1/4;")
    assert rows["no report, which counts as wrong above"][0].startswith("25.0 % (1/4;")
    assert rows["0.90 to 0.97"][:2] == ["95.0 %", "0.0 % (0/1; 0.0 to 79.3)"]
    assert "two at once: both found" not in rows
    assert rows["cubic spring"] == ["1/3", "1/2 |"]
    assert rows["chain, exact"] == ["5.0", "49.1", "50.0", "< 30", "MemoryError (1) |"]
    text = "\n".join(lines)
    assert f"`{CODE.commit}`, 2026-11-28." in text
    assert "Cases ran 2 at a time on a machine." in text
    assert "Not complete" not in text
    assert str(FIRST)[:3] not in text
    assert "'node'" not in text


def test_the_numbers_are_there_for_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    hide_cubic_springs(monkeypatch)
    numbers = content(some_certificate())
    assert json.loads(json.dumps(numbers, allow_nan=False))
    assert (numbers["commit"], numbers["done"], numbers["planned"]) == (CODE.commit, 6, 6)
    exact = numbers["columns"][0]
    assert exact["right_by_hidden"]["cubic_spring"]["hits"] == 1
    assert [item["right"]["hits"] for item in exact["calibration_by_named"]["added_mass"]] == [0]
    assert exact["verdicts"] == {"nothing_wrong": 1, "explained": 2}
    right = {verdict: own["hits"] for verdict, own in exact["right_by_verdict"].items()}
    assert right == {"nothing_wrong": 1}  # what was hidden is too weak to matter; the others name something
    assert exact["failures"] == {"MemoryError": 1}


def test_pages_are_written_beside_each_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hide_cubic_springs(monkeypatch)
    numbers, text = write(some_certificate(), tmp_path)
    assert json.loads(numbers.read_text())["schema"] == 1
    assert text.read_text().startswith("# Certificate")
    assert numbers.parent == text.parent == tmp_path


def test_a_certificate_of_no_case_yet_has_a_page() -> None:
    assert "Not complete: 0 of 6 cases" in page(certificate(CODE, certificate_work.COLUMNS, {}))


def test_a_case_without_a_report_is_right_in_nothing() -> None:
    for word in ("nothing", "gap_stop", "drifting_stiffness"):
        own = Record(None, "MemoryError", "", "").result(Task(1, word, BlindConfig()))
        assert not (own.judgement.first or own.judgement.listed or own.judgement.is_immaterial)
        assert Share(0, 1).interval[0] == 0.0


def hide_cubic_springs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have cubic springs alone hidden in the plan."""
    monkeypatch.setattr("benchmarks.certificate.plan.default_words", lambda _: ("cubic_spring",))


# The command


@pytest.fixture
def quick_door(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The command with few cases of other seeds, answered at once; its page goes into the folder that is returned."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(door, "COLUMNS", certificate_work.COLUMNS)
    monkeypatch.setattr(door, "ROOT", tmp_path)
    monkeypatch.setattr(door, "code_of", of_code)
    monkeypatch.setattr(door, "run", partial(run, code=of_code, work=right))
    return tmp_path / "docs"


@pytest.mark.slow
def test_the_command_writes_the_page_and_prints_the_rates(quick_door: Path) -> None:
    ran = CliRunner().invoke(app, ["--certificate"])
    assert ran.exit_code == 0, ran.output
    assert "so far" not in ran.output
    assert (quick_door / "certificate.json").is_file()
    rates = [line for line in (quick_door / "certificate.md").read_text().splitlines() if "kind and place" in line]
    assert rates[0] in ran.output.splitlines()
    assert len(list(Path("runs/certificate", CODE.commit[:12], "cases").iterdir())) == 6


def test_the_command_out_of_time_says_how_to_go_on(quick_door: Path) -> None:
    ran = CliRunner().invoke(app, ["--certificate", "--minutes", "0", "--out", "mine"])
    assert ran.exit_code == 0, ran.output
    assert "0 of 6 cases so far; the same command goes on from there" in ran.output
    assert "Not complete: 0 of 6" in (quick_door / "certificate.md").read_text()
    assert json.loads((quick_door.parent / INSTALLED).read_text())["commit"] == CODE.commit
    assert Path("mine/run.json").is_file()


def test_an_interrupted_command_keeps_what_is_done(quick_door: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> Certificate:
        raise KeyboardInterrupt

    monkeypatch.setattr(door, "run", interrupted)
    ran = CliRunner().invoke(app, ["--certificate", "--out", "mine"])
    assert ran.exit_code == door.INTERRUPTED
    assert "What is done is kept in mine; the same command goes on from there." in ran.output
    assert not quick_door.exists()
