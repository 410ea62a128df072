"""The extended structure: it moves as the diagnosis forecasts, and every script takes it as a model."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring, Effect, ModalDamping, PointDamper
from fe_models.damping import full_damping
from fe_models.files.dataset_file import load_dataset, save_dataset
from fe_models.files.models import load_model
from fe_models.files.structure_file import save_structure
from fe_models.modes import natural_modes
from fe_models.recordings import Assumptions, Dataset, Recording
from fe_models.simulation import FreeConfig, simulate_free
from fe_models.structure import Damping, Structure
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.extend import extended_structure
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from scripts.build_fe_model import app as build
from tests.masts import masts, recorded

CONFIG = BlindConfig(tier="off", size=0.8, train=3, test=1, duration=20.0)


def finding(cause: Effect) -> Finding:
    return Finding(cause, {}, 1.0, 1.0, (), (), "")


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["stiffness_change", "cubic_spring"])
def test_it_moves_as_the_diagnosis_forecasts(kind: str, tmp_path: Path) -> None:
    """From the fitted initial states, simulated in Exudyn: 0.3 % of each channel's range, a fifth of the noise.

    What is left is that calibrated damping is written with the nominal modes' own ratios, to first order.
    """
    data = blind_case(14, replace(CONFIG, kinds=(kind,))).dataset
    found = diagnose(data)
    assert [f.cause.kind for f in found.findings] == [kind]
    save_structure(found.extended, tmp_path / "extended_model.toml")
    model = load_model("extended_model.toml", tmp_path)
    assert isinstance(model, Structure)
    best = found.posterior.fits[0]
    states = best.states[0]
    motion = simulate_free(model, states[:, :4], states[:, 4:8], FreeConfig(20.0, 10.0, 0.02), progress=False)
    simulated = np.stack([motion.shown(s) for s in data.sensors], axis=-1)
    system = system_of(best.hypothesis, best.theta[None], SensorOutputs(data.sensors, 10.0, (0, 1, 2, 3, -1)))
    forecast = respond(system, states[None], simulated.shape[1])[0]
    error = np.sqrt(np.mean((forecast - simulated) ** 2, axis=1)) / np.ptp(forecast, axis=1)
    assert error.max() < 3e-3


@pytest.mark.slow
def test_nothing_is_wrong_with_the_extended_structure() -> None:
    data = blind_case(14, replace(CONFIG, kinds=("stiffness_change",))).dataset
    again = diagnose(replace(data, model=diagnose(data).extended))
    assert again.verdict is Verdict.NOTHING_WRONG


def test_calibrated_damping_is_written_exactly_where_the_modes_stay() -> None:
    """C of the chain couples the modes, more so than calibration changes it; only each mode's own part is scaled."""
    nominal = nominal_model_of(Dataset(four_dof(), 10.0, (), ()))
    factors = np.array([0.7, 1.2, 1.0, 0.9])
    built = extended_structure(nominal, np.append(np.zeros(len(nominal.parts)), np.log(factors)), ())
    drawn = linearise(four_dof())
    shapes = natural_modes(drawn, 4).shapes
    before, after = (shapes.T @ full_damping(linear) @ shapes for linear in (drawn, linearise(built)))
    np.testing.assert_allclose(after, before * (1 + np.diag(factors - 1)), atol=1e-12)


def test_assumed_damping_is_written_into_it_in_place_of_the_structures_own() -> None:
    data = Dataset(four_dof(), 10.0, (), (), assumptions=Assumptions(damping_ratio=0.03))
    nominal = nominal_model_of(data)
    built = extended_structure(nominal, np.zeros(nominal.factors), ())
    np.testing.assert_allclose(natural_modes(linearise(built), 4).damping_ratio, 0.03, rtol=1e-9)
    assert built.dashpots == ()


def test_damping_that_was_found_outlives_an_assumed_ratio() -> None:
    """The extended structure as the model of the same dataset, whose simulation assumes its ratios again."""
    data = Dataset(four_dof(), 10.0, (), (), assumptions=Assumptions(damping_ratio=0.03))
    nominal = nominal_model_of(data)
    found = (finding(ModalDamping((2,), 0.08)), finding(PointDamper((1,), "x", 0.2)))
    built = extended_structure(nominal, np.zeros(nominal.factors), found)
    own = nominal_model_of(replace(data, model=built)).own_ratios
    shapes, omega = natural_modes(linearise(four_dof()), 4).shapes, natural_modes(linearise(four_dof()), 4).omega
    expected = np.where(np.arange(4) == 1, 0.08, 0.03 + 0.2 * shapes[0] ** 2 / (2 * omega))
    np.testing.assert_allclose(own, expected, rtol=1e-6)


def test_it_is_simulated_and_diagnosed_as_a_model(tmp_path: Path) -> None:
    nominal = nominal_model_of(Dataset(four_dof(), 10.0, (), ()))
    built = extended_structure(nominal, np.zeros(nominal.factors), (finding(CubicSpring((1,), "x", 0.4)),))
    save_structure(built, tmp_path / "extended_model.toml")
    options = ["--out", str(tmp_path / "out"), "--no-pictures", "--simulate", "--realisations", "3"]
    sensors = ["--sensor", "4:x:displacement", "--sensor", "1:x"]
    done = CliRunner().invoke(build, [str(tmp_path / "extended_model.toml"), *options, *sensors])
    assert done.exit_code == 0, done.output
    simulated = load_dataset(tmp_path / "out" / "dataset.toml")
    assert isinstance(simulated.model, Structure)
    assert [effect.kind for effect in simulated.model.effects] == ["cubic_spring"]
    recording = Recording("r", simulated.recordings[0].data[:1])
    path = save_dataset(replace(simulated, recordings=(recording,)), tmp_path / "again")
    assert nominal_model_of(load_dataset(path)).laws


def test_calibrated_damping_of_a_mode_that_an_effect_sets_is_written_into_the_effect(tmp_path: Path) -> None:
    """As a modal ratio on top it was negative, and the file refused: nothing was written at all."""
    structure = masts().with_effects(ModalDamping((2,), 0.02))
    nominal = nominal_model_of(recorded(structure))
    theta, factor = np.zeros(len(nominal.spread)), np.exp(-0.05)
    theta[len(nominal.parts) : nominal.factors] = -0.05
    extended = extended_structure(nominal, theta, ())
    save_structure(extended, tmp_path / "extended_model.toml")
    found, drawn = (natural_modes(linearise(s), 4).damping_ratio for s in (extended, structure))
    np.testing.assert_allclose(found, factor * drawn, rtol=1e-6)


def test_modes_that_causes_bring_have_the_ratios_of_their_numbers_in_the_list() -> None:
    ratios = (0.01, 0.012, 0.014, 0.016, 0.018, 0.05, 0.06)
    structure = replace(masts(), damping=Damping(modal_ratios=ratios))
    nominal = nominal_model_of(recorded(structure))
    np.testing.assert_array_equal(nominal.ratios_of(8), [*ratios, ratios[-1]])
    assert len(nominal.ratios) < 6
