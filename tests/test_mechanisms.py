"""What moves without resistance is found and named, whatever the mesh; what is merely soft is not."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models import modes
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.linear_checks import check_linear_model
from fe_models.mechanisms import describe_mechanism, free_motions
from fe_models.modes import natural_modes
from fe_models.statics import PointLoad, rest_state
from fe_models.structure import Cable, Structure
from tests.problems import WIRE, cantilever


def without_supports(structure: Structure, monkeypatch: pytest.MonkeyPatch) -> LinearModel:
    """Return the linear model of ``structure`` as it is, unchecked."""
    monkeypatch.setattr("fe_models.assembly.require_structure", lambda given: given)
    return linearise(structure)


@pytest.mark.parametrize("divisions", [1, 8, 60])
@pytest.mark.parametrize("largest_dense", [0, 400])
def test_a_floating_structure_names_three_motions(
    divisions: int, largest_dense: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(modes, "LARGEST_DENSE_SOLVE", largest_dense)
    model = without_supports(replace(bridge(), supports=()).refined(divisions), monkeypatch)
    assert free_motions(model.stiffness).shape[1] == 3
    with pytest.raises(InputError) as caught:
        natural_modes(model, 3)
    x, y, turn = caught.value.faults
    assert "nodes 1, 2, 3, 4, 5 and" in x
    assert "can move in x without resistance" in x
    assert "can move in y" in y
    assert "can turn (rz)" in turn


@pytest.mark.parametrize("divisions", [1, 60])
def test_a_deck_without_cables_sways_and_nothing_else_does(divisions: int, monkeypatch: pytest.MonkeyPatch) -> None:
    structure = replace(bridge(), elements=bridge().elements[:52]).refined(divisions)
    model = without_supports(structure, monkeypatch)
    (fault,) = describe_mechanism(model)
    inner = 28 * (divisions - 1)
    assert f"nodes 1, 2, 3, 4, 5 and {24 + inner} more can move in x" in fault


def test_a_node_without_stiffness_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    hanging = replace(
        bridge(), nodes=(*bridge().nodes, (0.0, 1.0)), elements=(*bridge().elements, Cable((40, 56), WIRE))
    )
    faults = describe_mechanism(without_supports(hanging, monkeypatch))
    assert [fault.split(" without")[0] for fault in faults] == ["node 56 can move in y", "node 56 can turn (rz)"]


def test_a_buckled_state_is_called_unstable() -> None:
    column = replace(cantilever(divisions=8), nodes=((0.0, 0.0), (0.0, 2.0)))
    section = column.elements[0].section  # type: ignore[union-attr]  # a beam, see `cantilever`
    critical = np.pi**2 * section.bending_stiffness / (4 * 2.0**2)
    pressed = rest_state(column, gravity=0.0, loads=(PointLoad(2, "y", -1.1 * critical),))
    with pytest.raises(InputError, match="unstable"):
        natural_modes(linearise(column, pressed), 2)


def test_sound_models_have_no_faults() -> None:
    assert check_linear_model(linearise(bridge())) == []


def test_each_fault_of_the_matrices_is_one_line() -> None:
    model = linearise(cantilever())
    lopsided = model.stiffness.toarray()
    lopsided[0, 1] += 1e3
    nan = model.damping.copy()
    nan = nan + np.nan * model.mass
    faults = check_linear_model(replace(model, stiffness=type(model.mass)(lopsided), damping=nan, mass=model.mass[:2]))
    assert len(faults) == 3
    assert "M is 2 x 3; the dof map has 3 free" in faults[0]
    assert "C holds numbers that are not finite" in faults[1]
    assert "K is not symmetric: 1000 between node 2 in x and node 2 in y, 0 the other way round" in faults[2]


def test_masses_must_be_positive() -> None:
    model = linearise(cantilever())
    assert "nothing has mass" in check_linear_model(replace(model, mass=0 * model.mass))[0]
    assert "negative mass" in check_linear_model(replace(model, mass=-model.mass))[0]
    indefinite = np.array([[1.0, 0, 0], [0, 1.0, 2.0], [0, 2.0, 1.0]])
    assert "not positive" in check_linear_model(replace(model, mass=type(model.mass)(indefinite)))[0]


def test_coordinates_must_cover_the_nodes() -> None:
    model = linearise(cantilever())
    (fault,) = check_linear_model(replace(model, coordinates=model.coordinates[:1]))
    assert "names nodes 1 to 2; coordinates are given for nodes 1 to 1" in fault
