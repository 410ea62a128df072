"""Structures driven from rest in Exudyn: against an independent solver, as sensors show it, and by the command."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import fe_models as fe
from fe_models.base_motion import BaseMotion
from fe_models.causes import CoulombFriction, CubicSpring
from fe_models.drive import drive_of
from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset
from fe_models.files.structure_file import save_structure
from fe_models.recordings import Load
from fe_models.simulation import FreeConfig, ReleaseConfig, simulate_driven
from hybrid.commands.app import app
from tests.test_diagnosis_base_motion import RATE, SAMPLES, STOREYS, TIME, TOWER, every_sensor, quake, shaken, solved


def test_a_chain_with_a_cubic_spring_on_a_moving_base_is_that_of_another_solver() -> None:
    values = quake(4, highest=8.0)
    law = STOREYS.with_effects(CubicSpring((1,), "x", 2e7))
    found = simulate_driven(law, drive_of(law, [BaseMotion("x", values)], RATE), progress=False)
    displacement, velocity, acceleration = solved(STOREYS, {"x": values}, cubic=2e7, node=1)
    for own, truth in (
        (found.displacement, displacement),
        (found.velocity, velocity),
        (found.acceleration, acceleration),
    ):
        np.testing.assert_allclose(own, truth, atol=1e-6 * np.abs(truth).max())  # order 6 in a step of phase 0.1
    assert found.ground is not None
    np.testing.assert_allclose(found.ground[2, :, 0], values, atol=1e-9)
    np.testing.assert_allclose(np.gradient(found.ground[0, :, 0], TIME)[2:-2], found.ground[1, 2:-2, 0], atol=1e-2)


@pytest.mark.slow
def test_a_frame_on_a_moving_base_tends_to_another_solver_with_the_square_of_its_step() -> None:
    """So little that nothing geometric is felt; the supports carry part of a consistent mass."""
    base = {"x": 1e-3 * quake(1, highest=6.0), "y": 1e-3 * quake(2, highest=6.0)}
    motion = solved(TOWER, base)
    drive = drive_of(TOWER, [BaseMotion(axis, values) for axis, values in base.items()], RATE)  # type: ignore[arg-type]
    rows = [3, 6]  # of x at both free nodes
    errors = []
    for step in (1e-3, 5e-4):
        found = simulate_driven(TOWER, drive, ReleaseConfig(sampling_rate=500.0, step=step, gravity=0.0), False)
        errors.append(np.abs(found.displacement[::5, rows] - motion[0][:, rows]).max() / np.abs(motion[0]).max())
    assert errors[1] < 2e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)


def test_friction_under_a_strong_motion_needs_no_step_of_the_user() -> None:
    """Friction at rest is sharper than any mode; a fifth of the step that is taken changes nothing that matters."""
    law = STOREYS.with_effects(CoulombFriction((1,), "x", 20.0))
    drive = drive_of(law, [BaseMotion("x", quake(4, highest=8.0)[:81])], RATE)
    usual, finer = (
        simulate_driven(law, drive, FreeConfig(sampling_rate=RATE, step=step), progress=False).displacement
        for step in (None, 2e-4)
    )
    assert np.abs(usual - finer).max() < 1e-4 * np.abs(finer).max()


def test_a_load_and_a_base_together_are_the_sum_of_both() -> None:
    load, base = Load(3, "x", 40 * quake(7)), BaseMotion("x", quake(8))
    parts = [simulate_driven(STOREYS, drive_of(STOREYS, own, RATE), progress=False) for own in ([load], [base])]
    both = simulate_driven(STOREYS, drive_of(STOREYS, [load, base], RATE), progress=False)
    np.testing.assert_allclose(both.displacement, parts[0].displacement + parts[1].displacement, atol=1e-10)


def test_simulated_recordings_are_what_a_diagnosis_computes_of_absolute_and_relative_sensors() -> None:
    sensors = tuple(
        replace(sensor, name=str(i), unit=unit)
        for i, (sensor, unit) in enumerate(zip(every_sensor(2), ("m", "m/s", "m/s^2") * 2, strict=True))
    )
    base = BaseMotion("x", quake(9))
    dataset = fe.simulate(STOREYS, sensors, excitation=[base], sampling_rate=RATE, noise=0.0)
    (recording,) = dataset.recordings
    assert recording.data.shape == (1, SAMPLES, 6)
    np.testing.assert_array_equal(recording.base[0].values, base.values)
    computed = shaken(STOREYS, sensors, base)
    np.testing.assert_allclose(recording.data[0], computed, atol=1e-6 * np.abs(computed).max())
    difference = recording.data[0][:, 5] - recording.data[0][:, 2]
    np.testing.assert_allclose(difference, base.values, atol=1e-9)  # absolute less relative acceleration


def test_what_cannot_drive_a_structure_is_told_at_once() -> None:
    with pytest.raises(InputError) as caught:
        fe.simulate(STOREYS, ["a1"], excitation=[(Load(9, "x", TIME), BaseMotion("up", TIME[:50]))])  # type: ignore[arg-type]
    faults = "\n".join(caught.value.faults)
    for part in (
        "node 9 has no degree of freedom 'x'",
        "direction = 'up' is none",
        "50, 401 samples; give all as many",
    ):
        assert part in faults


def test_the_command_simulates_base_motion_from_a_column_in_g(tmp_path: Path) -> None:
    save_structure(STOREYS, tmp_path / "storeys.toml")
    lines = [f"{time},{value}" for time, value in zip(TIME, quake(3) / 9.80665, strict=True)]
    (tmp_path / "quake.csv").write_text("\n".join(["time,ag", *lines]))
    options = ["--base", f"{tmp_path / 'quake.csv'}:ag", "--base-unit", "g", "--sensor", "3:x", "--no-pictures"]
    command = ["simulate", str(tmp_path / "storeys.toml"), "--out", str(tmp_path / "out"), *options]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 0, result.output
    (recording,) = load_dataset(tmp_path / "out" / "dataset.toml").recordings
    np.testing.assert_allclose(recording.base[0].values, quake(3), rtol=1e-9)
    assert recording.excitation == "measured"
    wrong = CliRunner().invoke(app, [*command, "--pull", "1:x:3", "--base-direction", "up", "--base-unit", "gal"])
    assert wrong.exit_code == 2
    for part in ("--pull: goes not with --base", "--base-direction: direction = 'up' is none", "--base-unit gal"):
        assert part in wrong.output
