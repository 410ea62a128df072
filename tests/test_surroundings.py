"""A command in surroundings that are not its own: full disks, closed pipes, other runs, other languages."""

import fcntl
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from fe_models.errors import InputError, OutputError
from fe_models.files.atomic import FORGOTTEN, MACHINE, TEMPORARY, check_folder, write_text
from fe_models.files.result_list import LIST_FILE
from fe_models.files.result_set import ResultSet
from fe_models.files.run_guard import guarded, lock_folder, remember, remembered

CART = (
    'schema = 1\nname = "cart"\nnodes = [[0.0, 0.0]]\ndirections = ["x"]\n'
    'elements = [{ kind = "spring", nodes = [1], direction = "x", stiffness = 40.0 }]\n'
    "point_masses = [{ node = 1, mass = 1.0 }]\n"
)
BUILD = [sys.executable, "-m", "hybrid.commands.main", "build", "cart.toml", "--out", "out", "--no-pictures"]


@pytest.fixture
def cart(tmp_path: Path) -> Path:
    (tmp_path / "cart.toml").write_text(CART)
    return tmp_path


def run(folder: Path, words: list[str] = BUILD, **settings: object) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False, **settings)  # type: ignore


@contextmanager
def running(code: str, folder: Path) -> Iterator[None]:
    """A process that has said "ready"; at the end it is killed."""
    with subprocess.Popen([sys.executable, "-c", code, str(folder)], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        try:
            yield
        finally:
            process.kill()


def test_a_listener_that_leaves_costs_no_result(cart: Path) -> None:
    """As in ``hybrid-modal ... | head -1``, and where stdout is closed."""
    for close in ("| true", ">&-", ">/dev/full"):
        out = cart / f"out{len(close)}"
        words = " ".join(word if word != "out" else out.name for word in BUILD)
        found = run(cart, ["bash", "-o", "pipefail", "-c", f"{words} {close}"])
        assert (out / "model.npz").is_file()
        assert found.returncode == (1 if "full" in close else 0), found.stderr
        assert found.stderr.count("\n") == (1 if "full" in close else 0), found.stderr


def test_letters_that_a_terminal_lacks_are_spelt_out(cart: Path) -> None:
    (cart / "brücke").mkdir()
    (cart / "cart.toml").rename(cart / "brücke/träger.toml")
    names = {"cart.toml": "brücke/träger.toml", "out": "brücke/maß"}
    words = [names.get(word, word) for word in BUILD]
    ascii_only = os.environ | {"PYTHONIOENCODING": "ascii", "LC_ALL": "C"}
    found = run(cart, words, env=ascii_only)
    assert found.returncode == 0, found.stderr
    assert "br\\xfccke" in found.stdout
    assert (cart / "brücke/maß/model.npz").is_file()


@pytest.mark.slow
def test_a_full_disk_leaves_the_older_results_and_says_so(cart: Path) -> None:
    """The limit on the size of a file stands for a disk: what writes beyond either gets an error."""
    assert run(cart).returncode == 0
    before = {path.name: path.read_bytes() for path in (cart / "out").iterdir()}
    (cart / "cart.toml").write_text(CART.replace("40.0", "50.0"))

    def small() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200))

    found = run(cart, preexec_fn=small)
    assert found.returncode == 1, found.stderr
    assert "Traceback" not in found.stderr
    assert "cannot be written (File too large)" in found.stderr
    assert {path.name: path.read_bytes() for path in (cart / "out").iterdir()} == before


def test_a_name_that_is_too_long_is_found_before_the_work(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="name is too long"):
        check_folder(tmp_path / ("x" * 300))
    with pytest.raises(InputError, match="name is too long"):
        check_folder(tmp_path / "/".join(["y" * 200] * 25))
    with pytest.raises(InputError, match="no name of a folder"):
        check_folder(tmp_path / "a\0b")
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_run_left_goes_with_the_next(tmp_path: Path) -> None:
    """A file of a run that lives stays, and so does one of the user's."""
    code = (
        "import sys, time; from pathlib import Path; from fe_models.files.atomic import writing\n"
        "with writing(Path(sys.argv[1], 'training.pt')) as new:\n"
        "    new.write_text('half'); print('ready', flush=True); time.sleep(60)\n"
    )
    (tmp_path / ".my-notes-2026.txt").write_text("mine")
    results = ResultSet(tmp_path, "train", ("checkpoint.pt",))
    with running(code, tmp_path):
        results.check()
        assert len(list(tmp_path.iterdir())) == 2
    results.check()
    assert [path.name for path in tmp_path.iterdir()] == [".my-notes-2026.txt"]
    assert not TEMPORARY.match(".my-notes-2026.txt")


def test_what_another_machine_writes_on_a_shared_disk_stays(tmp_path: Path) -> None:
    """Its processes are not known here; what it has not touched for a day was left."""
    other = f"{int(MACHINE, 16) ^ 1:04x}"
    fresh, old = (tmp_path / f".{name}-999999999-{other}0123.npz" for name in ("fresh", "old"))
    folders = [tmp_path / f".new-train-{machine}0123" for machine in (other, MACHINE)]
    for path in (fresh, old):
        path.write_text("half")
    for folder in folders:
        folder.mkdir()
    os.utime(old, (time.time() - 1.1 * FORGOTTEN,) * 2)
    results = ResultSet(tmp_path, "train", ("a.txt",))
    results.check()
    with results.replacing() as new:
        write_text(new / "a.txt", "whole")
    assert {path.name for path in tmp_path.iterdir()} == {fresh.name, folders[0].name, "a.txt", LIST_FILE}


def test_two_runs_do_not_write_into_one_folder(tmp_path: Path) -> None:
    code = "from fe_models.files.run_guard import *\nfrom pathlib import Path\nimport sys, time\n"
    code += "with guarded():\n    lock_folder(Path(sys.argv[1])); print('ready', flush=True); time.sleep(60)\n"
    with running(code, tmp_path), guarded(), pytest.raises(InputError, match="another run writes into this folder"):
        ResultSet(tmp_path / "../" / tmp_path.name, "train", ("x",)).check()
    with guarded():  # the lock went with its process
        lock_folder(tmp_path)
        lock_folder(tmp_path)  # the same run may ask again
    assert list(tmp_path.iterdir()) == []


def test_an_input_that_changes_meanwhile_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    path.write_text("a\n1\n")
    with guarded() as guard:
        remember([path, tmp_path / "none.csv"])
        known = remembered(path)
        assert guard.changed() == []
        path.write_text("a\n2\n")
        remember([path])  # later the same run looks again
        assert guard.changed() == [path]
        assert remembered(path) == known
    assert remembered(path) is None


def test_a_change_is_said_at_the_end(cart: Path) -> None:
    code = (
        "from pathlib import Path\nimport hybrid.commands.models as models\nwrite = models.write_model\n"
        "def late(*a): Path('cart.toml').write_text(Path('cart.toml').read_text() + '# new'); write(*a)\n"
        "models.write_model = late\nfrom hybrid.commands.app import app\n"
        "app(['build', 'cart.toml', '--out', 'out', '--no-pictures'])\n"
    )
    found = run(cart, [sys.executable, "-c", code])
    assert found.returncode == 0, found.stderr
    assert found.stderr == "note: cart.toml was changed while this ran; the results are of what it held before\n"


@pytest.mark.slow
def test_an_interrupt_in_the_first_seconds_is_one_line(cart: Path) -> None:
    """While libraries are loaded; the interpreter itself takes the first hundredths of a second."""
    endings = set[tuple[int, str]]()
    for wait in (0.1, 0.2, 0.4, 0.7):
        process = subprocess.Popen(BUILD, cwd=cart, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        time.sleep(wait)
        process.send_signal(signal.SIGINT)
        _, words = process.communicate(timeout=60)
        endings.add((process.returncode, words))
    assert {code for code, _ in endings} <= {130, 0}
    assert all("Traceback" not in words and words.count("\n") <= 1 for _, words in endings)


def test_disk_errors_have_their_own_status(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(path: Path, content: bytes) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(OutputError, match="No space left on device") as caught:
        write_text(tmp_path / "a.txt", "words")
    assert caught.value.status == 1
    assert list(tmp_path.iterdir()) == []


def test_locks_are_the_operating_systems(tmp_path: Path) -> None:
    with guarded() as guard:
        lock_folder(tmp_path)
        (number,) = guard.locks.values()
        assert fcntl.fcntl(number, fcntl.F_GETFD) & fcntl.FD_CLOEXEC  # children do not hold it on
