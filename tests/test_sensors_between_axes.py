"""Sensors between the axes: what they see is the same combination of two along the axes, through every path."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import fe_models as fe
from fe_models.base_motion import BaseMotion
from fe_models.causes import StiffnessChange
from fe_models.directions import direction_of_text, direction_text, direction_words
from fe_models.errors import InputError
from fe_models.files.atomic import write_npz
from fe_models.files.dataset_file import load_dataset, save_dataset
from fe_models.files.matrices_file import load_linear_model
from fe_models.linear import LinearModel
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Load, Quantity, Recording, Sensor
from fe_models.sensing import seen
from hybrid.commands.app import app
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.nominal.any_model import any_nominal_model_of
from hybrid.identification.computed_response import computed_response
from hybrid.known_loads.modal_input import modal_input
from hybrid.neural_modal_ode.decoder import sensor_shapes
from tests.frames import gable, vibrations
from tests.space_frames import two_storeys

ACROSS = (3.0, -4.0)
TURN = np.array([0.6, -0.8])  # of a sensor along it, from sensors along x and y
QUANTITIES: tuple[Quantity, ...] = ("displacement", "velocity", "acceleration")


def at(direction: object, quantity: Quantity = "acceleration", node: int = 3, **options: Any) -> Sensor:
    unit = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}[quantity]
    return Sensor(f"{quantity} {direction}", node, direction, quantity, unit, **options)  # type: ignore[arg-type]


def axes(quantity: Quantity = "acceleration", **options: Any) -> tuple[Sensor, Sensor]:
    return at("x", quantity, **options), at("y", quantity, **options)


@pytest.fixture
def floors(tmp_path: Path) -> LinearModel:
    write_npz(tmp_path / "floors.npz", two_storeys())
    return load_linear_model(tmp_path / "floors.npz")


def test_a_sensor_sees_its_components(floors: LinearModel) -> None:
    dofs = natural_modes(gable(), 1).dofs
    np.testing.assert_allclose(seen(dofs, [at(ACROSS)])[0], TURN @ seen(dofs, axes()), rtol=1e-15)
    np.testing.assert_allclose(seen(dofs, [at(90.0)]), seen(dofs, [at("y")]), atol=1e-16)
    rising = at((0.0, 3.0, 4.0))  # nothing of these floors moves in z
    np.testing.assert_allclose(seen(floors.dofs, [rising]), 0.6 * seen(floors.dofs, [at("y")]))
    with pytest.raises(InputError, match="sensor 'acceleration z': node 3 has no degree of freedom 'z'"):
        seen(floors.dofs, [at("z")])


@pytest.mark.parametrize("direction", ["x", 30.0, -12.5, (3.0, -4.0), (1.0, 0.0, 2.0)])
def test_a_direction_is_read_from_its_text(direction: object) -> None:
    assert direction_of_text(direction_text(direction)) == direction  # type: ignore[arg-type]


def test_directions_in_words() -> None:
    assert [direction_words(each) for each in ("rz", 30.0, ACROSS)] == ["rz", "(0.866, 0.5)", "(0.6, -0.8)"]


def test_datasets_keep_what_lies_between_axes(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    sensors = (at(30.0), at(ACROSS, node=5), at("y"))
    data = Dataset(gable(), 100.0, sensors, (Recording("r", rng.standard_normal((1, 64, 3))),))
    assert load_dataset(save_dataset(data, tmp_path)).sensors == sensors
    text = (tmp_path / "dataset.toml").read_text()
    (tmp_path / "dataset.toml").write_text(text.replace("node = 3, direction = 30.0", "node = 1, direction = 30.0"))
    with pytest.raises(InputError) as caught:
        load_dataset(tmp_path / "dataset.toml")
    assert len(caught.value.faults) == 2  # that both components of the pinned foot are held
    assert "node 1 is held in x by a support; the sensor would read zero" in caught.value.faults[0]


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_what_is_simulated_and_computed_is_the_turned_motion_of_the_axes(
    floors: LinearModel, quantity: Quantity
) -> None:
    """Of matrices on a base that moves, absolute and relative, in simulation, modal input, decoder and functions."""
    rng = np.random.default_rng(1)
    quake, force = BaseMotion((1.0, 2.0), rng.standard_normal(64)), Load(3, "x", 1e3 * rng.standard_normal(64))
    for reference in ("absolute", "base"):
        turned, pair = at(ACROSS, quantity, reference=reference), axes(quantity, reference=reference)
        data = fe.simulate(floors, [turned, *pair], excitation=[[quake, force]], noise=0.0)
        shown = data.recordings[0].data[0]
        np.testing.assert_allclose(shown[:, 0], shown[:, 1:] @ TURN, atol=1e-12 * np.abs(shown).max())
        modal = natural_modes(floors, 4)
        entered = modal_input(data, modal, data.recordings)
        assert entered is not None
        at_once = entered.shown_at_once(data.recordings[0], entered.courses(data.recordings[0]))
        np.testing.assert_allclose(at_once[:, 0], at_once[:, 1:] @ TURN, atol=1e-9 * np.abs(at_once).max())
        shapes = sensor_shapes(modal, data.sensors)
        np.testing.assert_allclose(shapes[0], TURN @ shapes[1:], atol=1e-15)
        inputs = [(3, "x"), (0.6, 0.8)]
        found = computed_response(floors, data.sensors, inputs, np.array([1.3, 4.0]))  # type: ignore[arg-type]
        np.testing.assert_allclose(found[..., 0], found[..., 1:] @ TURN, rtol=1e-9)


def test_the_simulation_of_a_structure_shows_the_turned_motion_on_a_moving_base() -> None:
    course = np.sin(0.3 * np.arange(40.0))
    data = fe.simulate(gable(), [at(ACROSS), *axes()], excitation=[BaseMotion("y", course)], noise=0.0)
    shown = data.recordings[0].data[0]
    np.testing.assert_allclose(shown[:, 0], shown[:, 1:] @ TURN, atol=1e-9 * np.abs(shown).max())


def test_the_models_of_a_diagnosis_show_it(floors: LinearModel) -> None:
    """Of a structure, and of matrices by groups, whose coordinates know the places of sensors alone."""
    for model in (gable(), floors):
        sensors = (at(ACROSS), *axes())
        recording = Recording("r", np.random.default_rng(0).standard_normal((1, 200, 3)))
        nominal = any_nominal_model_of(Dataset(model, 100.0, sensors, (recording,)))
        rows = nominal.rows(sensors)
        np.testing.assert_allclose(rows[0], TURN @ rows[1:], atol=1e-12)
        assert np.abs(rows[0]).max() > 0.5


def turned_hall() -> Dataset:
    """Return vibrations of a hall with a soft rafter, by sensors all of which are turned."""
    sensors = tuple(
        at(direction, node=node) for node, direction in ((2, 20.0), (3, ACROSS), (4, 75.0), (6, (1.0, 1.0)))
    )
    soft = gable().with_effects(StiffnessChange((5,), 0.6))
    return vibrations(gable(), soft, sensors, 4)


@pytest.mark.slow
def test_a_diagnosis_names_what_turned_sensors_show() -> None:
    found = diagnose(turned_hall())
    (finding,) = found.findings
    assert isinstance(finding.cause, StiffnessChange)
    assert finding.cause.elements == (5,)
    assert finding.cause.factor == pytest.approx(0.6, abs=0.02)


@pytest.mark.slow
def test_the_commands_take_turned_sensors(tmp_path: Path) -> None:
    write_npz(tmp_path / "floors.npz", two_storeys())

    def called(*words: object) -> str:
        answer = CliRunner().invoke(app, [str(word) for word in words])
        assert answer.exit_code == 0, answer.output
        return answer.output

    pulls = ("--pull", "3:x:1000+4:y:-200", "--pull", "2:y:500+3:x:900", "--pull", "3:x:800+3:y:500")
    sensors = ("--sensor", "3:30", "--sensor", "4:3,-4", "--sensor", "2:y", "--sensor", "2:100::held_out")
    called("simulate", tmp_path / "floors.npz", "--out", tmp_path / "data", *pulls, *sensors[:6], "--duration", "6")
    file = tmp_path / "data" / "dataset.toml"
    names = [(sensor.name, sensor.direction) for sensor in load_dataset(file).sensors]
    assert names == [("a3(30)", 30.0), ("a4(3,-4)", (3.0, -4.0)), ("a2y", "y")]
    assert (tmp_path / "data" / "sensors.png").stat().st_size > 5000
    assert "MAC" in called("compare", file, "--out", tmp_path / "compared")
    options = ("--window", "80", "--batch", "8", "--first-horizon", "20", "--threads", "1", "--epochs", "1")
    called("train", file, "--out", tmp_path / "run", *options)
    called("predict", tmp_path / "run", "--out", tmp_path / "next", "--dataset", file, "--recording", "release_3")
    header = (tmp_path / "next" / "channels.csv").read_text().splitlines()[0]
    assert "a3(30)" in header
    wrong = CliRunner().invoke(app, ["simulate", str(tmp_path / "floors.npz"), "--out", str(tmp_path / "w"), *sensors])
    assert "--sensor 2:100::held_out: expected NODE:DIRECTION" in wrong.output
