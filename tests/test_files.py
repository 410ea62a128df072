"""Whatever interrupts a writing, the target is the old file or the whole new one."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fe_models.errors import InputError, bad_input_exits
from fe_models.files.atomic import write_json, write_npz, write_text, writing


def test_text_json_and_arrays_come_back(tmp_path: Path) -> None:
    write_text(tmp_path / "new" / "folder" / "a.txt", "déjà\nvu\n")
    assert (tmp_path / "new" / "folder" / "a.txt").read_text(encoding="utf-8") == "déjà\nvu\n"
    write_json(tmp_path / "a.json", {"nrmse": 0.1})
    assert json.loads((tmp_path / "a.json").read_text()) == {"nrmse": 0.1}
    write_npz(tmp_path / "a.npz", {"x": [1.0, 2.0]})
    with np.load(tmp_path / "a.npz", allow_pickle=False) as archive:
        assert archive["x"].tolist() == [1.0, 2.0]


def test_equal_arrays_make_equal_files(tmp_path: Path) -> None:
    for name in ("a.npz", "b.npz"):
        write_npz(tmp_path / name, {"x": np.arange(5)})
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


@pytest.mark.skipif(os.name != "posix", reason="an open file cannot be replaced on Windows")
def test_who_reads_the_old_file_reads_all_of_it(tmp_path: Path) -> None:
    write_text(tmp_path / "a.txt", "old")
    with (tmp_path / "a.txt").open() as reader:
        write_text(tmp_path / "a.txt", "new")
        assert reader.read() == "old"
    assert (tmp_path / "a.txt").read_text() == "new"


@pytest.mark.parametrize("interruption", [KeyboardInterrupt, RuntimeError])
def test_an_interrupted_writing_leaves_the_old_file_alone(tmp_path: Path, interruption: type[BaseException]) -> None:
    target = tmp_path / "result.txt"
    write_text(target, "old")
    with pytest.raises(interruption), writing(target) as temporary:
        temporary.write_text("half of the n")
        raise interruption
    assert target.read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["result.txt"]


@pytest.mark.skipif(os.name != "posix", reason="kill -9 exists only on POSIX systems")
def test_a_killed_writing_leaves_the_old_file_alone(tmp_path: Path) -> None:
    target = tmp_path / "result.txt"
    write_text(target, "old")
    program = (
        "import os, signal, sys; from pathlib import Path; from fe_models.files.atomic import writing\n"
        "with writing(Path(sys.argv[1])) as path: path.write_text('half'); os.kill(os.getpid(), signal.SIGKILL)"
    )
    root = Path(__file__).parents[1]
    done = subprocess.run([sys.executable, "-c", program, str(target)], cwd=root, check=False)
    assert done.returncode == -signal.SIGKILL
    assert target.read_text() == "old"


def test_the_temporary_file_keeps_the_suffix_and_folder(tmp_path: Path) -> None:
    with writing(tmp_path / "shape.png") as temporary:
        assert (temporary.suffix, temporary.parent) == (".png", tmp_path)
        temporary.write_bytes(b"x")


def test_what_a_plain_file_cannot_hold_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="JSON"):
        write_json(tmp_path / "a.json", {"nrmse": float("nan")})
    with pytest.raises(TypeError, match="Python objects cannot be saved: x"):
        write_npz(tmp_path / "a.npz", {"x": np.array([{}], dtype=object)})
    assert list(tmp_path.iterdir()) == []


def test_an_impossible_target_is_bad_input(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="its folder cannot be made"):
        write_text(tmp_path / "file" / "a.txt", "x")
    with pytest.raises(InputError, match="is a folder"):
        write_text(tmp_path, "x")


def test_bad_input_exits_with_one_line_a_fault(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_info, bad_input_exits():
        raise InputError(["first\nfault", "second"])
    assert exit_info.value.code == 2
    assert capsys.readouterr().err == "error: first fault\nerror: second\n"


def test_other_errors_and_interrupts_pass() -> None:
    for error in (KeyboardInterrupt, ZeroDivisionError):
        with pytest.raises(error), bad_input_exits():
            raise error
