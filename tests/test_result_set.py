"""Results of a command: what is the user's stays, what the command wrote is exchanged as a set, whatever interrupts."""

import os
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

import pytest

from fe_models.errors import InputError, bad_input_exits
from fe_models.files import result_set
from fe_models.files.atomic import write_text
from fe_models.files.result_list import LIST_FILE
from fe_models.files.result_set import ResultSet, finish_exchanges


def results(folder: Path) -> ResultSet:
    return ResultSet(folder, "train", ("scores.json", "model.npz", "mode_*.png"))


def write(folder: Path, **texts: str) -> None:
    """Replace the results in ``folder`` by files of these names, with "." for "_"."""
    with results(folder).replacing() as new:
        for name, text in texts.items():
            write_text(new / name.replace("_", "."), text)


def content(folder: Path) -> dict[str, str]:
    """All files of a folder but the list, hidden ones and those in folders among them."""
    files = [path for path in folder.rglob("*") if path.is_file() and path.name != LIST_FILE]
    return {path.relative_to(folder).as_posix(): path.read_text() for path in files}


def refusal(act: Callable[[], object]) -> tuple[str, ...]:
    with pytest.raises(InputError) as caught:
        act()
    return caught.value.faults


def test_a_second_run_replaces_what_the_first_wrote_and_nothing_else(tmp_path: Path) -> None:
    """Files that it no longer makes go, too: they would be taken for its own."""
    with results(tmp_path).replacing() as new:
        for name in ("scores.json", "mode_1.png", "mode_2.png"):
            write_text(new / name, "old")
    write_text(tmp_path / "notes.txt", "mine")
    write_text(tmp_path / "pictures" / "mode_1.png", "mine")
    results(tmp_path).check()
    with results(tmp_path).replacing() as new:
        for name in ("scores.json", "mode_1.png"):
            write_text(new / name, "new")
    assert content(tmp_path) == {
        "notes.txt": "mine",
        "pictures/mode_1.png": "mine",
        "scores.json": "new",
        "mode_1.png": "new",
    }


def test_every_file_that_must_stay_is_named_before_the_work(tmp_path: Path) -> None:
    """The user's, an input, another command's, and one of the command's own that the user changed since."""
    with ResultSet(tmp_path, "build", ("model.npz",)).replacing() as new:
        write_text(new / "model.npz", "built")
    with results(tmp_path).replacing() as new:
        write_text(new / "mode_1.png", "old")
        write_text(new / "mode_2.png", "old")
    write_text(tmp_path / "mode_2.png", "retouched")
    write_text(tmp_path / "mode_3.png", "mine")
    write_text(tmp_path / "mode_4.png", "mine")
    write_text(tmp_path / "scores.json", "read")
    before = content(tmp_path)
    faults = refusal(lambda: results(tmp_path).check([tmp_path / "scores.json", tmp_path / "missing.toml"]))
    remedy = f"give another folder, such as {tmp_path / 'train'}"
    assert sorted(faults) == sorted(
        f"{tmp_path}: {words}; {remedy}"
        for words in (
            "scores.json would be replaced, but is read by this run",
            "model.npz would be replaced, but is written by build",
            "mode_2.png would be replaced, but is changed since train wrote it",
            "mode_3.png, mode_4.png would be replaced, but are not on the list of files that this program wrote there",
        )
    )
    assert content(tmp_path) == before


def test_an_input_is_refused_although_the_command_itself_wrote_it(tmp_path: Path) -> None:
    """Under any name of the file: through another folder, or a link."""
    write(tmp_path / "run", scores_json="old")
    (tmp_path / "link").symlink_to(tmp_path / "run", target_is_directory=True)
    os.link(tmp_path / "run" / "scores.json", tmp_path / "same.json")
    for read in (tmp_path / "run" / ".." / "run" / "scores.json", tmp_path / "link" / "scores.json"):
        assert "read by this run" in refusal(lambda read=read: results(tmp_path / "run").check([read]))[0]  # type: ignore[misc]
    assert "read by this run" in refusal(lambda: results(tmp_path / "run").check([tmp_path / "same.json"]))[0]
    results(tmp_path / "run").check([tmp_path / "other.json"])


def test_a_failure_leaves_the_older_results_whole(tmp_path: Path) -> None:
    write(tmp_path, scores_json="old", model_npz="old")
    before = {**content(tmp_path), LIST_FILE: (tmp_path / LIST_FILE).read_text()}

    def failing(error: Exception) -> None:
        with results(tmp_path).replacing() as new:
            write_text(new / "scores.json", "new")
            raise error

    with pytest.raises(ZeroDivisionError) as caught:
        failing(ZeroDivisionError())
    assert "older ones are as they were" in caught.value.__notes__[0]
    (fault,) = refusal(lambda: failing(OSError(28, "No space left on device")))
    assert "not all results of train could be written" in fault
    assert "No space left on device" in fault
    assert {**content(tmp_path), LIST_FILE: (tmp_path / LIST_FILE).read_text()} == before


def test_a_failing_addition_leaves_what_was_written_before_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The report is kept where its picture fails, and no picture of an older report stands beside it."""
    with results(tmp_path).replacing() as new:
        write_text(new / "scores.json", "old")
        write_text(new / "mode_1.png", "old")
    write(tmp_path, scores_json="new")

    def drawing() -> NoReturn:
        with results(tmp_path).adding() as new:
            write_text(new / "mode_1.png", "half")
            raise InputError("there is nothing to draw")

    with pytest.raises(SystemExit), bad_input_exits():
        drawing()
    first, second = capsys.readouterr().err.splitlines()
    assert first == "error: there is nothing to draw"
    assert second.startswith("note: ")
    assert "whole (scores.json)" in second
    assert content(tmp_path) == {"scores.json": "new"}
    with results(tmp_path).adding() as new:
        write_text(new / "mode_1.png", "new")
    results(tmp_path).check()  # both are the command's own
    assert content(tmp_path) == {"scores.json": "new", "mode_1.png": "new"}


class Killed(BaseException):
    """What ends a process: nothing is done after it."""


def killed_at(step: int, monkeypatch: pytest.MonkeyPatch, act: Callable[[], None]) -> bool:
    """Do ``act``, but stop it dead at its file operation number ``step``; return whether it came so far."""
    done = 0

    def counted(operation: Callable[..., Any]) -> Callable[..., Any]:
        def perform(*arguments: Any, **options: Any) -> Any:
            nonlocal done
            done += 1
            if done > step:
                raise Killed
            return operation(*arguments, **options)

        return perform

    with monkeypatch.context() as patch:
        for name in ("replace", "rename", "unlink", "mkdir"):
            patch.setattr(Path, name, counted(getattr(Path, name)))
        patch.setattr(shutil, "rmtree", counted(shutil.rmtree))
        try:
            act()
        except Killed:
            return True
    return False


def test_killed_at_any_step_all_results_are_the_old_ones_or_all_the_new(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After whoever comes next has completed the exchange; the next run finds nothing in its way."""
    old = {"scores.json": "old", "mode.1.png": "old"}
    new = {"scores.json": "new", "model.npz": "new"}
    outcomes = []
    for step in range(100):
        folder = tmp_path / str(step)
        ours = ResultSet(folder, "train", ("scores.json", "model.npz", "mode.*.png"))
        with ours.replacing() as fresh:
            for name, text in old.items():
                write_text(fresh / name, text)

        def again(ours: ResultSet = ours) -> None:
            with ours.replacing() as fresh:
                for name, text in new.items():
                    write_text(fresh / name, text)

        killed = killed_at(step, monkeypatch, again)
        if not list(folder.glob(".exchange-*")) and killed:
            assert {name: text for name, text in content(folder).items() if "/" not in name} in (old, new)
        finish_exchanges(folder)
        found = {name: text for name, text in content(folder).items() if not name.startswith(".new-")}
        assert found in (old, new)
        outcomes.append(found == new)
        again()
        assert content(folder) == new
        assert not [path for path in folder.iterdir() if path.is_dir()]
        if not killed:
            break
    assert outcomes == sorted(outcomes)  # first the old ones, from one step on the new
    assert not outcomes[0]
    assert outcomes[-2]  # there is a step at which the rest is left to the next who comes


def overtaken_at(step: int, monkeypatch: pytest.MonkeyPatch, act: Callable[[], None], other: Callable[[], None]) -> int:
    """Do ``act``, and all that the ``other`` does before its file operation ``step``; return how many it has."""
    done = 0

    def counted(operation: Callable[..., Any]) -> Callable[..., Any]:
        def perform(*arguments: Any, **options: Any) -> Any:
            nonlocal done
            done += 1
            if done == step:
                other()
            return operation(*arguments, **options)

        return perform

    with monkeypatch.context() as patch:
        for name in ("replace", "unlink", "rmdir", "mkdir", "fsync"):
            patch.setattr(os, name, counted(getattr(os, name)))
        act()
    return done


def test_two_who_complete_one_exchange_at_once_do_not_stop_each_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whichever step the slower one is at when the faster one has done all: what is gone is done."""
    step, steps = 0, 1
    while step < steps:
        step += 1
        folder = tmp_path / str(step)
        write(folder, scores_json="old", model_npz="old")

        with monkeypatch.context() as patch:
            patch.setattr(result_set, "finish_exchanges", lambda folder: None)  # interrupted before
            write(folder, scores_json="new")
        assert list(folder.glob(".exchange-*"))
        finish = partial(finish_exchanges, folder)
        steps = overtaken_at(step, monkeypatch, finish, finish)
        assert content(folder) == {"scores.json": "new"}
        assert not [path for path in folder.iterdir() if path.is_dir()]
        write(folder, model_npz="newer")
        assert content(folder) == {"model.npz": "newer"}
    assert steps > 5


def test_a_file_that_the_user_puts_there_meanwhile_stays_and_the_results_are_kept(tmp_path: Path) -> None:
    write(tmp_path, scores_json="old")

    def run() -> None:
        with results(tmp_path).replacing() as new:
            write_text(new / "scores.json", "new")
            write_text(tmp_path / "scores.json", "mine")

    *_, last = refusal(run)
    rescued = Path(last.rpartition(" ")[2])
    assert last.startswith("the new results of train are in ")
    assert rescued.parent == tmp_path
    assert content(rescued) == {"scores.json": "new"}
    assert (tmp_path / "scores.json").read_text() == "mine"


def test_a_file_changed_after_an_interruption_is_not_written_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, scores_json="old")
    for step in range(100):
        assert killed_at(step, monkeypatch, lambda: write(tmp_path, scores_json="new"))
        if list(tmp_path.glob(".exchange-*")):
            break
    write_text(tmp_path / "scores.json", "mine")
    (fault,) = refusal(lambda: results(tmp_path).check())
    assert "scores.json: was changed after train was interrupted" in fault
    assert "move it away" in fault
    (tmp_path / "scores.json").rename(tmp_path / "mine.json")
    results(tmp_path).check()
    assert content(tmp_path) == {"mine.json": "mine", "scores.json": "new"}


@pytest.mark.parametrize(
    "text", ["{", '{"results": []}', '{"results": {"train": {"../scores.json": "00"}}}', "[]", '{"results": {"a": 1}}']
)
def test_a_list_that_is_none_of_ours_is_refused(text: str, tmp_path: Path) -> None:
    """Above all one that reaches into other folders: what it names is removed."""
    write_text(tmp_path / "run" / LIST_FILE, text)
    (fault,) = refusal(lambda: results(tmp_path / "run").check())
    assert "is not the list of results" in fault


def test_a_folder_that_cannot_be_one_is_refused(tmp_path: Path) -> None:
    write_text(tmp_path / "file", "mine")
    assert "is a file" in refusal(lambda: results(tmp_path / "file").check())[0]
    results(tmp_path / "not" / "yet" / "there").check()
    assert content(tmp_path) == {"file": "mine"}


def test_a_file_that_a_command_does_not_declare_is_an_error_of_the_program(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"notes\.txt"), results(tmp_path).replacing() as new:
        write_text(new / "notes.txt", "")
    assert content(tmp_path) == {}


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="this system has no folder in which nothing can be made")
def test_a_folder_that_cannot_be_made_is_refused_before_any_work() -> None:
    with pytest.raises(InputError, match="nothing can be written into /proc; choose another folder"):
        ResultSet(Path("/proc/results"), "build", ("model.npz",)).check()
