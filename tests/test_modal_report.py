"""The command that diagnoses by modes alone: what it writes and says of a chain that is off, and has changed."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import fe_models as fe
from fe_models.files.dataset_file import save_dataset
from fe_models.files.structure_file import load_structure, save_structure
from hybrid.commands.app import app
from tests.blank_sheets import blank_sheets
from tests.test_modal_evidence import SENSORS, chain

SAMPLES, RATE = 2000, 50.0


def decays(structure: fe.Structure, rng: np.random.Generator) -> np.ndarray:
    """Return displacements (motion, time, sensor) of the free decay of all modes, and noise of 1 %."""
    modal = fe.natural_modes(structure, len(SENSORS))
    ratio, omega = modal.damping_ratio, modal.omega
    roots = omega * (-ratio + 1j * np.sqrt(1 - ratio**2))
    waves = np.exp(np.outer(np.arange(SAMPLES) / RATE, roots))
    clean = np.real((waves * np.exp(2j * np.pi * rng.uniform(size=len(omega)))) @ modal.shapes.T)
    return np.asarray(clean + 0.01 * clean.std(axis=0) * rng.standard_normal(clean.shape))[None]


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The dataset of a chain whose springs are off by up to a fifth, and whose third lost a quarter before the last
    recording.
    """
    rng = np.random.default_rng(50)
    truth = chain(np.array([0.85, 1.15, 1.1, 0.9, 1.2]))
    changed = truth.with_effects(fe.StiffnessChange((3,), 0.75))
    recordings = tuple(
        fe.Recording(name, decays(structure, rng))
        for name, structure in (("monday", truth), ("tuesday", truth), ("friday", changed))
    )
    return save_dataset(fe.Dataset(chain(), RATE, SENSORS, recordings), tmp_path_factory.mktemp("modes"))


@pytest.mark.slow
def test_a_changed_chain_far_from_its_drawing(file: Path, tmp_path: Path) -> None:
    answer = CliRunner().invoke(app, ["diagnose", str(file), "--by-modes", "--out", str(tmp_path)])
    assert answer.exit_code == 0, answer.output
    report = json.loads((tmp_path / "report.json").read_text())
    first = report["findings"][0]
    assert (first["kind"], first["location"], first["recordings"]) == ("stiffness_change", {"element": 3}, ["friday"])
    factor = first["parameters"]["factor"]
    assert factor["value"] == pytest.approx(0.75, abs=4 * factor["std"])
    assert [state["recordings"] for state in report["states"]] == [["monday", "tuesday"], ["friday"]]
    assert "It acts in friday only." in answer.output
    assert (tmp_path / "summary.txt").read_text().strip() in answer.output
    assert (tmp_path / "what_is_wrong.png").stat().st_size > 10_000
    assert (tmp_path / "modes.png").stat().st_size > 10_000
    extended = load_structure(tmp_path / "extended_model.toml")
    stiffness = [element.stiffness for element in extended.elements if isinstance(element, fe.Spring)]
    assert stiffness[1] / stiffness[0] == pytest.approx(1.15 / 0.85, rel=0.05)  # all of them together only modes' scale


TABLE = """
schema = 1
model = "{model}"
sensors = [{sensors}]
"""


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three springs off, the fourth at 0.7 afterwards; frequencies to a thousandth, no damping, one shape not known."""
    folder = tmp_path_factory.mktemp("table")
    truth = chain(np.array([0.9, 1.1, 1.0, 1.1, 0.95]))
    changed = truth.with_effects(fe.StiffnessChange((4,), 0.7))
    save_structure(chain(), folder / "drawn.toml")
    names = ", ".join(
        f'{{ name = "{s.name}", node = {s.node}, direction = "x", quantity = "acceleration", unit = "m/s^2" }}'
        for s in SENSORS
    )
    text = [TABLE.format(model="drawn.toml", sensors=names)]
    for name, structure in (("before", truth), ("after", changed)):
        modal = fe.natural_modes(structure, len(SENSORS))
        for number, (frequency, shape) in enumerate(zip(modal.frequencies, modal.shapes.T, strict=True)):
            text.append(
                f'[[modes]]\nrecording = "{name}"\nfrequency = {frequency:.6f}\nfrequency_std = {frequency / 1000}'
            )
            if number != 4:
                text.append(f"shape = {np.round(shape, 4).tolist()}\nshape_std = 0.01")
    (folder / "modes.toml").write_text("\n".join(text))
    return folder / "modes.toml"


@pytest.mark.slow
@blank_sheets()
def test_a_table_of_modes_is_enough(table: Path, tmp_path: Path) -> None:
    answer = CliRunner().invoke(app, ["diagnose", str(table), "--out", str(tmp_path / "out")])
    assert answer.exit_code == 0, answer.output
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    first = report["findings"][0]
    assert (first["kind"], first["location"]) == ("stiffness_change", {"element": 4})
    factor = first["parameters"]["factor"]
    wanted = 0.7 if first["recordings"] == ["after"] else 1 / 0.7  # which of the two is as drawn, nobody knows
    assert factor["value"] == pytest.approx(wanted, abs=4 * factor["std"])
    assert len(report["states"]) == 2
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for words in (f"stiffness change at element 4 in {first['recordings'][0]}", "no cause, nominal values alone"):
        assert f'<th scope="row">{words}</th>' in page  # the best hypothesis, and what it beat


def test_nothing_is_learned_from_a_table_of_modes(table: Path, tmp_path: Path) -> None:
    trained = CliRunner().invoke(app, ["diagnose", str(table), "--hybrid", "--out", str(tmp_path / "new")])
    assert trained.exit_code == 2
    assert "--hybrid" in trained.output
    assert not (tmp_path / "new").exists()
