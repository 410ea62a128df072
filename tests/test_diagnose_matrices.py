"""The command on matrices by groups: what it finds, writes and says; and that a structure file gets the same answer."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import fe_models as fe
from fe_models.causes import StiffnessChange
from fe_models.files.atomic import write_npz
from fe_models.files.dataset_file import save_dataset
from fe_models.files.matrices_file import load_linear_model
from fe_models.files.models import load_model
from fe_models.linear import LinearModel
from fe_models.matrix_effects import model_with_effects
from fe_models.recordings import Assumptions, Sensor, Uncertainty
from fe_models.structure import Direction
from hybrid.commands.app import app
from hybrid.diagnosis.modes_and_motion.modal_diagnosis import diagnose_modes
from hybrid.diagnosis.outcome.verdict import Verdict
from tests.matrices_of import matrices_of
from tests.space_frames import FOLLOWED, two_storeys
from tests.test_modal_evidence import SENSORS, chain
from tests.test_modal_report import RATE, decays

PLACES: tuple[tuple[int, Direction], ...] = ((2, "x"), (2, "y"), (FOLLOWED, "y"), (3, "x"), (3, "y"))
FLOORS = tuple(Sensor(f"a{node}{axis}", node, axis, "acceleration", "m/s^2") for node, axis in PLACES)


def decay(model: LinearModel, rng: np.random.Generator, rate: float = 50.0, seconds: float = 40.0) -> np.ndarray:
    """Return accelerations (motion, time, sensor) of the free decay of all modes, and noise of 1 %."""
    modal = fe.natural_modes(model)
    omega, ratio = modal.omega, modal.damping_ratio
    roots = omega * (-ratio + 1j * np.sqrt(1 - ratio**2))
    waves = np.exp(np.outer(np.arange(round(seconds * rate)) / rate, roots)) * np.exp(
        2j * np.pi * rng.uniform(size=len(omega))
    )
    rows = [modal.dofs.row(sensor.node, str(sensor.direction)) for sensor in FLOORS]
    clean = np.real(waves @ modal.shapes[rows].T)
    return np.asarray(clean + 0.01 * clean.std(axis=0) * rng.standard_normal(clean.shape))[None]


@pytest.mark.slow
def test_a_storey_of_a_building_in_space_that_lost_stiffness(tmp_path: Path) -> None:
    """Read by a sensor at a corner that follows its floor, too; the extended model forecasts what was measured."""
    write_npz(tmp_path / "floors.npz", two_storeys())
    model, rng = load_linear_model(tmp_path / "floors.npz"), np.random.default_rng(3)
    damaged = model_with_effects(model, StiffnessChange((), 0.8, "storey 2"))
    recordings = tuple(fe.Recording(name, decay(own, rng)) for name, own in (("may", model), ("june", damaged)))
    assumed = Assumptions(uncertainty=Uncertainty(0.05, 0.05, 0.1))
    file = save_dataset(fe.Dataset(model, 50.0, FLOORS, recordings, assumptions=assumed), tmp_path / "data")
    answer = CliRunner().invoke(app, ["diagnose", str(file), "--out", str(tmp_path / "out")])
    assert answer.exit_code == 0, answer.output
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    first = report["findings"][0]
    assert (first["kind"], first["location"], first["recordings"]) == (
        "stiffness_change",
        {"group": "storey 2"},
        ["june"],
    )
    factor = first["parameters"]["factor"]
    assert factor["value"] == pytest.approx(0.8, abs=4 * factor["std"] + 1e-3)
    assert "Group 'storey 2' has 0.8" in answer.output
    extended = load_model("extended_model.toml", tmp_path / "out")
    assert isinstance(extended, LinearModel)
    np.testing.assert_allclose(fe.natural_modes(extended).omega, fe.natural_modes(damaged).omega, rtol=2e-3)


@pytest.mark.slow
def test_free_decays_of_a_building_in_space_are_forecast_to_the_floor(tmp_path: Path) -> None:
    write_npz(tmp_path / "floors.npz", two_storeys())
    model, rng = load_linear_model(tmp_path / "floors.npz"), np.random.default_rng(3)
    damaged = model_with_effects(model, StiffnessChange((), 0.8, "storey 2"))
    train = tuple(fe.Recording(name, decay(damaged, rng)) for name in "ab")
    test = fe.Recording("t", decay(damaged, rng), "test")
    assumed = Assumptions(uncertainty=Uncertainty(0.05, 0.05, 0.1))
    found = diagnose_modes(fe.Dataset(model, 50.0, FLOORS, (*train, test), assumptions=assumed))
    assert found.verdict is Verdict.EXPLAINED
    assert [finding.cause.location for finding in found.findings] == [{"group": "storey 2"}]
    before, after = (found.scores[name]["measured"] for name in ("baseline", "extended"))
    floor = found.noise_floor
    assert before is not None
    assert after is not None
    assert floor is not None
    assert after < 1.05 * floor < 0.1 * before


@pytest.mark.slow
def test_a_structure_and_its_matrices_are_diagnosed_alike() -> None:
    """Kind, place, size and probability of a chain's lost stiffness, and what each spring is off by."""
    rng = np.random.default_rng(50)
    truth = chain(np.array([0.85, 1.15, 1.1, 0.9, 1.2]))
    changed = truth.with_effects(fe.StiffnessChange((3,), 0.75))
    recordings = tuple(
        fe.Recording(name, decays(own, rng), excitation="free") for name, own in (("a", truth), ("b", changed))
    )
    drawn, given = (diagnose_modes(fe.Dataset(m, RATE, SENSORS, recordings)) for m in (chain(), matrices_of(chain())))
    first, other = drawn.findings[0], given.findings[0]
    assert other.cause.location == {"group": "elements 3"}
    assert other.recordings == first.recordings == ("b",)
    assert other.parameters["factor"].value == pytest.approx(first.parameters["factor"].value, abs=1e-3)
    assert other.probability == pytest.approx(first.probability, abs=0.02)
    for one, two in zip(drawn.calibration, given.calibration, strict=True):
        assert two.factor == pytest.approx(one.factor, abs=2e-3)


def test_hybrid_and_bare_matrices_are_refused(tmp_path: Path) -> None:
    model = matrices_of(chain())
    data = fe.Recording("r", decays(chain(), np.random.default_rng(0)))
    with_groups = save_dataset(fe.Dataset(model, RATE, SENSORS, (data,)), tmp_path / "with")
    answer = CliRunner().invoke(app, ["diagnose", str(with_groups), "--hybrid", "--out", str(tmp_path / "out")])
    assert answer.exit_code == 2
    assert "a diagnosis of matrices trains no hybrid models" in answer.output
    bare = save_dataset(fe.Dataset(replace(model, groups=()), RATE, SENSORS, (data,)), tmp_path / "bare")
    answer = CliRunner().invoke(app, ["diagnose", str(bare), "--out", str(tmp_path / "out")])
    assert answer.exit_code == 2
    assert "these name no groups of elements" in answer.output
