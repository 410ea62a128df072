"""Matrices in few coordinates: exact where nothing is changed, and near to the whole where a group or a place is."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.linalg import spsolve

from benchmarks.space_frame import corner, tall_frame
from fe_models.causes import AddedMass, StiffnessChange, SupportSpring
from fe_models.dof_map import DofMap
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.matrix_effects import matrix_changes_of, model_with_effects, pull_of
from fe_models.modes import mac, natural_modes
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.sensing import seen
from hybrid.diagnosis.nominal.any_model import any_nominal_model_of, with_parts_scaled
from hybrid.diagnosis.nominal.config import COORDINATES
from hybrid.diagnosis.nominal.coordinates import Coordinates, coordinates_of
from tests.matrices_of import matrices_of
from tests.test_modal_evidence import SENSORS, chain

BAYS, FLOORS, SHOWN = 2, 6, 6
TOP = corner(BAYS, FLOORS, far=True)


@pytest.fixture(scope="module")
def frame() -> LinearModel:
    return tall_frame(BAYS, FLOORS, 3)


@pytest.fixture
def few(frame: LinearModel, monkeypatch: pytest.MonkeyPatch) -> Coordinates:
    """The frame's 144 degrees of freedom as a large model's: modes and static shapes."""
    few_nodes = replace(COORDINATES, most_whole=0, most_nodes=8)
    monkeypatch.setattr("hybrid.diagnosis.nominal.coordinates.COORDINATES", few_nodes)
    return coordinates_of(
        frame, natural_modes(frame, SHOWN + 15), SHOWN, [Sensor("top", TOP, "x", "acceleration", "1")]
    )


def test_modes_stay_as_they_are(frame: LinearModel, few: Coordinates) -> None:
    assert len(few.model.dofs) < frame.mass.shape[0]
    exact = natural_modes(frame, SHOWN)
    reduced = natural_modes(few.model, SHOWN)
    np.testing.assert_allclose(reduced.omega, exact.omega, rtol=1e-9)  # of the eigenvalue solver
    moved = np.abs(few.pull(TOP, "x") @ reduced.shapes)
    np.testing.assert_allclose(moved, np.abs(exact.shapes[exact.dofs.row(TOP, "x")]), atol=1e-6 * moved.max())


def test_flexibility_is_exact_where_causes_are_sought(frame: LinearModel, few: Coordinates) -> None:
    for node in few.nodes:
        pull, whole = few.pull(node, "y"), pull_of(frame, ((node, "y", 1.0),))
        exact = float(whole @ spsolve(frame.stiffness.tocsc(), whole))
        assert float(pull @ spsolve(few.model.stiffness.tocsc(), pull)) == pytest.approx(exact, rel=1e-6)


def test_changes_are_nearly_those_of_the_whole(frame: LinearModel, few: Coordinates) -> None:
    """A lost third of a group's stiffness moves frequencies by 5 %; the coordinates err by less than 1 % of that."""
    group = frame.groups[0].name
    before = natural_modes(frame, SHOWN).omega
    exact = natural_modes(model_with_effects(frame, StiffnessChange((), 0.67, group)), SHOWN).omega
    found = natural_modes(model_with_effects(few.model, StiffnessChange((), 0.67, group)), SHOWN).omega
    assert np.abs(exact / before - 1).max() > 0.05
    np.testing.assert_allclose(found / before - 1, exact / before - 1, atol=0.01 * np.abs(exact / before - 1).max())


def test_a_large_change_of_a_tall_frame_is_seen_as_well_as_modes_are_measured() -> None:
    """Its columns lose 30 % over half its height. Long recordings tell frequencies to some 1e-5: what coordinates err
    by beyond stands in the answer as if it were another loss.
    """
    frame = tall_frame(4, 26, 13)
    lost = StiffnessChange((), 0.7, frame.groups[0].name)
    few = coordinates_of(frame, natural_modes(frame, 20), 12, ())
    assert len(few.model.dofs) < 0.1 * frame.mass.shape[0]
    exact = natural_modes(model_with_effects(frame, lost), 10).omega
    np.testing.assert_allclose(natural_modes(model_with_effects(few.model, lost), 10).omega, exact, rtol=3e-5)


def test_a_spring_and_a_mass_at_a_node_are_those_of_the_whole(frame: LinearModel, few: Coordinates) -> None:
    node = next(iter(few.nodes))
    pull = few.pull(node, "x")
    spring, before = 2e8, natural_modes(frame, SHOWN).omega  # N/m: raises the first frequency by a tenth
    exact = natural_modes(model_with_effects(frame, SupportSpring(node, "x", spring)), SHOWN).omega
    stiff = replace(few.model, stiffness=few.model.stiffness + spring * csr_array(np.outer(pull, pull)))
    found = natural_modes(stiff, SHOWN).omega
    assert np.abs(exact / before - 1).max() > 0.05
    np.testing.assert_allclose(found, exact, rtol=5e-3)
    dM = matrix_changes_of(frame, AddedMass(node, 1e4))[0]
    shapes = natural_modes(frame, SHOWN).shapes[frame.dofs.free]
    rows = np.array([few.pull(node, axis) for axis in few.directions(node)])
    own = rows @ natural_modes(few.model, SHOWN).shapes
    np.testing.assert_allclose(1e4 * np.sum(own**2, axis=0), np.diag(shapes.T @ (dM @ shapes)), rtol=1e-6)


def test_coordinates_take_effects_as_the_whole_does(frame: LinearModel, few: Coordinates) -> None:
    """With places that follow them they are a model as any: natural modes, what sensors see, causes at nodes."""
    node = next(iter(few.nodes))
    causes = StiffnessChange((), 0.8, frame.groups[0].name), SupportSpring(node, "x", 2e8), AddedMass(node, 1e4)
    exact = natural_modes(model_with_effects(frame, *causes), SHOWN)
    found = natural_modes(model_with_effects(few.placed, *causes), SHOWN)
    np.testing.assert_allclose(found.omega, exact.omega, rtol=5e-3)  # the spring alone moves the first by a tenth
    sensor = (Sensor("top", TOP, "x", "acceleration", "1"),)
    moved, expected = (np.abs(seen(own.dofs, sensor) @ own.shapes)[0] for own in (found, exact))
    np.testing.assert_allclose(moved, expected, atol=0.02 * expected.max())


def test_nodes_that_stand_for_others_move_most_apart(few: Coordinates, frame: LinearModel) -> None:
    every = {node for own, others in few.nodes.items() for node in (own, *others)}
    assert len(few.nodes) == 8
    assert every == {int(node) for node in frame.dofs.node[frame.dofs.free]}


def test_a_structure_and_its_matrices_have_one_nominal_model() -> None:
    """The same modes, sensors' rows and uncertain parts, whichever way the user writes the structure."""
    recordings = (Recording("r", np.random.default_rng(0).standard_normal((1, 200, 5))),)
    drawn, given = (
        any_nominal_model_of(Dataset(m, 50.0, SENSORS, recordings)) for m in (chain(), matrices_of(chain()))
    )
    np.testing.assert_allclose(given.modes[0], drawn.modes[0], rtol=1e-10)
    seen = [nominal.rows(SENSORS) @ nominal.modes[1] for nominal in (drawn, given)]
    np.testing.assert_allclose(np.diag(mac(*seen)), 1.0, rtol=1e-12)
    np.testing.assert_allclose(given.spread[: given.factors], drawn.spread[: drawn.factors])
    assert [part.quantity for part in given.parts] == [part.quantity for part in drawn.parts]
    factors = np.linspace(0.8, 1.2, len(given.parts))
    again = [
        with_parts_scaled(n, Dataset(m, 50.0, SENSORS, recordings), factors)
        for n, m in ((drawn, chain()), (given, matrices_of(chain())))
    ]
    np.testing.assert_allclose(again[1].modes[0], again[0].modes[0], rtol=1e-10)


def twice(matrix: csr_array) -> csr_array:
    return csr_array(np.kron(np.eye(2), matrix.toarray()))


def test_equal_frequencies_are_parted_by_less_than_a_model_knows() -> None:
    """A square tower sways alike in x and y; its shapes are along these once the mass differs by a thousandth."""
    square = matrices_of(chain())
    groups = tuple(replace(own, mass=twice(own.mass), stiffness=twice(own.stiffness)) for own in square.groups)
    dofs = DofMap(
        np.tile(square.dofs.node, 2), np.repeat(["x", "y"], len(square.dofs)), np.ones(2 * len(square.dofs), dtype=bool)
    )
    both = replace(
        square,
        mass=twice(square.mass),
        damping=twice(square.damping),
        stiffness=twice(square.stiffness),
        dofs=dofs,
        groups=groups,
    )
    data = Recording("r", np.random.default_rng(0).standard_normal((1, 200, 5)))
    nominal = any_nominal_model_of(Dataset(both, 50.0, SENSORS, (data,)))
    omega = nominal.modes[0]
    assert 1e-4 < omega[1] / omega[0] - 1 < 1e-3
    along_x = np.abs(nominal.rows(SENSORS) @ nominal.modes[1]).max(axis=0)
    assert along_x[0] < 1e-9 < along_x[1] or along_x[1] < 1e-9 < along_x[0]


def test_matrices_whose_modes_no_recording_can_show_are_refused() -> None:
    data = Recording("r", np.random.default_rng(0).standard_normal((1, 200, 5)))
    with pytest.raises(InputError, match=r"no natural frequency lies below 0.005 Hz .*check sampling_rate"):
        any_nominal_model_of(Dataset(matrices_of(chain()), 0.01, SENSORS, (data,)))


def test_matrices_without_groups_are_refused_with_the_remedy() -> None:
    bare = replace(matrices_of(chain()), groups=())
    data = Recording("r", np.random.default_rng(0).standard_normal((1, 200, 5)))
    with pytest.raises(InputError, match=r"these name no groups of elements: give the groups' shares"):
        any_nominal_model_of(Dataset(bare, 50.0, SENSORS, (data,)))
