"""How many modes there are where masses are few: defaults ask for no more, a user who does is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array
from typer.testing import CliRunner

from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.errors import InputError
from fe_models.mode_count import mode_count
from fe_models.modes import natural_modes
from fe_models.nominal import nominal_modes
from fe_models.recordings import Assumptions, Dataset, Sensor
from fe_models.sections import square_tube
from fe_models.structure import Beam, PointMass, Structure, Support
from hybrid.commands.app import app

TUBE = square_tube("tube", 2.1e11, 0.0, 0.1, 0.004)
PORTAL = Structure(
    "portal",
    ((0.0, 0.0), (0.0, 3.0), (4.0, 3.0), (4.0, 0.0)),
    tuple(Beam((node, node + 1), TUBE) for node in (1, 2, 3)),
    (PointMass(2, 50.0), PointMass(3, 50.0)),
    supports=(Support(1, ("x", "y", "rz")), Support(4, ("x", "y", "rz"))),
)
SENSORS = (Sensor("a2x", 2, "x", "acceleration", "m/s^2"),)


def test_two_point_masses_have_four_modes() -> None:
    assert mode_count(linearise(PORTAL)) == 4  # x and y of each; their rotations have no mass
    assert len(natural_modes(PORTAL).omega) == 4
    dataset = Dataset(PORTAL, 1000.0, SENSORS, ())
    assert len(nominal_modes(dataset, 10).omega) == 4
    for count in (5, 6):
        with pytest.raises(InputError, match=f"{count} modes asked for; only 4 have mass to move"):
            natural_modes(PORTAL, count)
        with pytest.raises(InputError, match=f"{count} modes asked for; only 4 have mass to move"):
            nominal_modes(replace(dataset, assumptions=Assumptions(modes=count)), 10)


def test_all_with_mass_of_their_own_have_as_many_modes_as_degrees_of_freedom() -> None:
    assert mode_count(linearise(four_dof())) == 4
    for divisions in (1, 3):
        model = linearise(bridge().refined(divisions))
        assert mode_count(model) == model.mass.shape[0]


def test_a_mass_on_a_rigid_arm_has_one_mode_for_two_degrees_of_freedom() -> None:
    """It moves by u - h theta: M = m [1, -h]^T [1, -h] has rank 1."""
    model = linearise(PORTAL)
    arm = np.zeros((6, 1))
    arm[:3, 0] = 1.0, 0.0, -0.5
    eccentric = replace(model, mass=csr_array(50.0 * arm @ arm.T))
    assert mode_count(eccentric) == 1
    (omega,) = natural_modes(eccentric).omega
    moved = arm[:, 0] @ np.linalg.solve(model.stiffness.toarray(), arm[:, 0])
    assert omega == pytest.approx((50.0 * moved) ** -0.5, rel=1e-9)


def test_the_command_builds_what_has_few_masses(tmp_path: Path) -> None:
    document = """
    schema = 1
    name = "portal"
    nodes = [[0.0, 0.0], [0.0, 3.0], [4.0, 3.0], [4.0, 0.0]]
    elements = [{ kind = "beam", through = [1, 2, 3, 4], section = "tube" }]
    point_masses = [{ node = 2, mass = 50.0 }, { node = 3, mass = 50.0 }]
    supports = [{ node = 1, directions = ["x", "y", "rz"] }, { node = 4, directions = ["x", "y", "rz"] }]
    [[sections]]
    name = "tube"
    youngs_modulus = 2.1e11
    density = 0.0
    shape = "square_tube"
    side = 0.1
    wall = 0.004
    """
    (tmp_path / "portal.toml").write_text(document)
    words = ["build", str(tmp_path / "portal.toml"), "--out", str(tmp_path / "out"), "--no-pictures"]
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 0, answer.output
    assert "\n   4   " in answer.output
    assert "\n   5   " not in answer.output
    refused = CliRunner().invoke(app, [*words, "--modes", "6"])
    assert refused.exit_code == 2
