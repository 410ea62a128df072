"""Options that nobody would give on purpose: an exit status of 2 and lines that say why, before any work."""

import os
from pathlib import Path

import pytest
from hypothesis import strategies as st
from typer.testing import CliRunner

from fe_models.errors import InputError
from hybrid.commands.app import app
from hybrid.config import configuration
from tests.odd_inputs import within
from tests.test_odd_inputs import EFFORTS, tried
from tests.test_surroundings import CART

ODD = [
    "nan",
    "inf",
    "-inf",
    "0",
    "-1",
    "1e-12",
    "1e300",
    "1e-300",
    "1e9",
    "9" * 400,
    "",
    "x",
    "a\x1b[31m",
    "1e400",
    "0x10",
]
OPTIONS = [
    "--realisations",
    "--duration", "--step", "--sampling-rate", "--lowpass", "--noise", "--gravity", "--seed",
    "--sensor",
    "--pull", "--base", "--base-direction", "--base-unit", "--refine", "--cubic-stiffness", "--modal-model",
]  # fmt: skip


@pytest.fixture
def cart(tmp_path: Path) -> Path:
    (tmp_path / "cart.toml").write_text(CART)
    return tmp_path / "cart.toml"


def ended(*words: str) -> tuple[int, str]:
    """Exit status and output of the command; whatever is no orderly end is raised."""
    with within():
        result = CliRunner().invoke(app, list(words))
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result.exit_code, result.output


@pytest.mark.parametrize("examples", [pytest.param(25, id="some"), *EFFORTS[1:]])
def test_simulate(cart: Path, examples: int) -> None:
    statuses = list[int]()

    def read(given: list[tuple[str, str]]) -> None:
        words = [word for pair in given for word in pair]
        few = [] if any(name == "--realisations" for name, _ in given) else ["--realisations", "2"]
        short = [] if any(name == "--duration" for name, _ in given) else ["--duration", "5"]
        out = ["--out", str(cart.parent / "out"), "--no-pictures", "--quiet"]
        status, words_said = ended("simulate", str(cart), *out, "--sensor", "1:x", *few, *short, *words)
        statuses.append(status)
        assert status in (0, 2), words_said
        assert "\x1b" not in words_said

    pairs = st.tuples(st.sampled_from(OPTIONS), st.sampled_from(ODD))
    tried(examples, st.lists(pairs, min_size=1, max_size=2), read)
    assert statuses.count(2) > examples / 3


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        (["--step", "1e-12"], "at most 1e+07"),
        (["--step", "nan"], "--step is nan"),
        (["--realisations", "1000000000"], "more than are kept"),
        (["--duration", "inf"], "--duration"),
        (["--noise", "1e300"], "--noise 1e300"),
        (["--sensor", "1:x"], "given 2 times"),
        (["--sampling-rate", "1e-9"], "expected 1e-06 to 1e+09 Hz"),
        (["--lowpass", "nan"], "--lowpass is nan"),
    ],
)
def test_what_is_odd_is_named(words: list[str], fault: str, cart: Path) -> None:
    status, said = ended("simulate", str(cart), "--out", str(cart.parent / "out"), "--sensor", "1:x", *words)
    assert status == 2
    assert fault in said.replace("\n", " ")
    assert not (cart.parent / "out").exists()


def test_a_step_longer_than_the_interval_of_samples_is_that(cart: Path) -> None:
    words = ["--sensor", "1:x", "--realisations", "2", "--duration", "5", "--no-pictures", "--step", "1e9"]
    status, said = ended("simulate", str(cart), "--out", str(cart.parent / "out"), *words)
    assert status == 0, said


@pytest.mark.parametrize(
    "model", ["/dev/zero", "fifo.toml", "a" * 5000 + ".toml", "x" * 300 + ".npz", "/proc/self/mem"]
)
def test_models_that_are_no_files(model: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("fifo.toml")
    status, said = ended("build", model, "--out", "out")
    assert status == 2
    assert len(said) < 3000


def test_numbers_of_a_training_have_limits() -> None:
    for name, value in {"epochs": 10**9, "batch": 0, "learning_rate": float("nan"), "net_hidden": 10**6}.items():
        with pytest.raises(InputError, match=f"{name}: expected"):
            configuration("default", "", {name: value})
