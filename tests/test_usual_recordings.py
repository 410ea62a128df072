"""How recordings are simulated where nothing is said: alike in Python and by the command."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

import fe_models as fe
from fe_models.files.atomic import write_npz
from fe_models.files.dataset_file import load_dataset
from fe_models.files.structure_file import save_structure
from fe_models.statics import PointLoad
from fe_models.synthetic import Acquisition
from fe_models.usual_recordings import Kind
from hybrid.commands.app import app
from tests.problems import cantilever
from tests.space_frames import two_storeys

PULLED = ["--pull", "2:y:1", "--sensor", "2:y", "--duration", "0.8", "--no-pictures"]


@pytest.mark.parametrize(
    ("kind", "given", "expected"),
    [
        (Kind.RELEASED, {}, Acquisition(100.0, 30.0, 0.02)),
        (Kind.RELEASED, {"sampling_rate": 50.0}, Acquisition(50.0, 15.0, 0.02)),
        (Kind.RELEASED, {"sampling_rate": 50.0, "lowpass": 0.0}, Acquisition(50.0, None, 0.02)),
        (Kind.RELEASED, {"lowpass": 20.0, "noise": 0.0}, Acquisition(100.0, 20.0, 0.0)),
        (Kind.RELEASED, {"lowpass": 60.0}, Acquisition(200.0, 60.0, 0.02)),
        (Kind.FREE, {}, Acquisition(10.0, None, 0.02)),
        (Kind.FREE, {"lowpass": 4.0}, Acquisition(10.0, 4.0, 0.02)),
        (Kind.FREE, {"lowpass": 6.0}, Acquisition(20.0, 6.0, 0.02)),
        (Kind.DRIVEN, {"sampling_rate": 400.0}, Acquisition(400.0, None, 0.02)),
        (Kind.DRIVEN, {"lowpass": 60.0}, Acquisition(100.0, 60.0, 0.02)),  # a file has one value a sample: refused
    ],
)
def test_what_is_not_given_follows_from_what_is(kind: Kind, given: dict[str, float], expected: Acquisition) -> None:
    found = kind.acquisition(**given)
    assert found.sampling_rate == pytest.approx(expected.sampling_rate, rel=1e-12)
    assert (found.lowpass, found.noise) == (expected.lowpass, expected.noise)


@pytest.mark.parametrize("rate", [50.0, 1000.0])
def test_the_command_and_python_record_alike(tmp_path: Path, rate: float) -> None:
    save_structure(cantilever(), tmp_path / "beam.toml")
    words = ["simulate", str(tmp_path / "beam.toml"), "--out", str(tmp_path / "out"), "--sampling-rate", str(rate)]
    answer = CliRunner().invoke(app, [*words, *PULLED])
    assert answer.exit_code == 0, answer.output
    by_command = load_dataset(tmp_path / "out" / "dataset.toml")
    by_python = fe.simulate(cantilever(), ["a2y"], pulls=[PointLoad(2, "y", 1.0)], duration=0.8, sampling_rate=rate)
    assert (by_command.sampling_rate, by_command.lowpass) == (by_python.sampling_rate, by_python.lowpass)
    assert by_command.lowpass == 0.3 * rate
    assert by_command.recordings[0].data.shape == by_python.recordings[0].data.shape


def test_options_of_a_base_are_refused_without_one_for_matrices_too(tmp_path: Path) -> None:
    write_npz(tmp_path / "floors.npz", two_storeys())
    words = ["simulate", str(tmp_path / "floors.npz"), "--out", str(tmp_path / "out"), *PULLED]
    answer = CliRunner().invoke(app, [*words, "--base-direction", "y", "--base-unit", "g"])
    assert answer.exit_code == 2
    for option in ("--base-direction", "--base-unit"):
        assert f"{option}: is of --base, which is not given" in answer.output
