"""The bridge: its make, its modes against an independent assembly and the authors', its answer to a load, P-delta."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat
from scipy.linalg import eigh

from fe_models.assembly import linearise
from fe_models.built_in.bridge import PAPER_FREQUENCIES, bridge
from fe_models.modes import mac, natural_modes
from fe_models.statics import PointLoad, rest_state
from fe_models.structure import Beam, Cable
from fe_models.structure_checks import check_structure
from tests.problems import frame_matrices

AUTHORS_MODES = Path(__file__).parents[2] / "shared/data/bridge/modal_para.mat"
FREQUENCIES = [1.6387, 3.4529, 6.3668, 11.2515, 13.6057, 14.7337, 18.7283, 20.0070, 20.2884, 26.3396]  # Hz


def test_make() -> None:
    structure = bridge()
    assert check_structure(structure) == []
    assert len(structure.nodes) == 55
    assert [sum(isinstance(item, kind) for item in structure.elements) for kind in (Beam, Cable)] == [52, 8]
    assert linearise(structure).mass.shape == (153, 153)
    assert structure.nodes[28] == (3.0, 0.0)
    assert structure.nodes[41] == (-1.8, 1.0)
    cables = [element.nodes for element in structure.elements if isinstance(element, Cable)]
    assert cables == [(1, 40), (4, 38), (38, 10), (40, 13), (17, 53), (20, 51), (51, 26), (53, 29)]
    prestress = [element.prestress for element in structure.elements if isinstance(element, Cable)]
    assert prestress == [38.6, 25.5, 23.8, 37.0, 37.0, 23.8, 25.5, 38.6]
    # 28 x 0.5 kg on the deck, 8 x 0.4 and 4 x 0.2 kg on each tower.
    assert sum(point.mass for point in structure.point_masses) == pytest.approx(14.0 + 2 * 4.0, rel=1e-12)


def test_is_its_own_mirror_image() -> None:
    structure = bridge()
    mirrored = {(-x, y) for x, y in structure.nodes}
    assert mirrored == set(structure.nodes)
    tensions = {
        frozenset(structure.nodes[node - 1] for node in element.nodes): (element.prestress, element.section)
        for element in structure.elements
        if isinstance(element, Cable)
    }
    assert tensions == {frozenset((-x, y) for x, y in ends): stay for ends, stay in tensions.items()}


def test_natural_frequencies() -> None:
    found = natural_modes(linearise(bridge()), 10).frequencies
    np.testing.assert_allclose(found, FREQUENCIES, rtol=1e-4)
    # The authors' tower masses and cables differ a little, see `bridge`.
    np.testing.assert_allclose(found, PAPER_FREQUENCIES, rtol=2e-4)
    np.testing.assert_allclose(found[:4], PAPER_FREQUENCIES[:4], rtol=5e-5)


def test_modes_are_those_of_an_independent_assembly() -> None:
    model = linearise(bridge())
    free = np.ix_(model.dofs.free, model.dofs.free)
    mass, stiffness = frame_matrices(bridge())
    mu, _ = eigh(mass[free], stiffness[free])  # from above: 1 / omega^2
    found = natural_modes(model, 153)
    np.testing.assert_allclose(found.omega[:20], 1 / np.sqrt(mu[::-1][:20]), rtol=1e-9)  # K has 1e-11 of rounding
    # and the highest mode is 1e4 times higher
    np.testing.assert_allclose(found.omega, 1 / np.sqrt(mu[::-1]), rtol=1e-6)


def test_shapes_are_the_authors() -> None:
    if not AUTHORS_MODES.exists():
        pytest.skip("modal_para.mat, the authors' modes of the bridge, is not at hand")
    theirs = loadmat(AUTHORS_MODES)["phi_aug"]
    ours = natural_modes(linearise(bridge()), 10)
    translations = ours.dofs.direction != "rz"  # their tower rotations have the other sign
    agreement = np.diag(mac(ours.shapes[translations], theirs[translations]))
    assert agreement.min() >= 0.9999


def test_static_answer_to_a_weight_at_node_19() -> None:
    model = linearise(bridge())
    free, row = model.dofs.free, model.dofs.row(19, "y")
    _, stiffness = frame_matrices(bridge())
    load = np.zeros(165)
    load[row] = -9.81
    expected = np.zeros(165)
    expected[free] = np.linalg.solve(stiffness[np.ix_(free, free)], load[free])
    ours = np.zeros(165)
    ours[free] = np.linalg.solve(model.stiffness.toarray(), load[free])
    np.testing.assert_allclose(ours, expected, atol=1e-9 * np.abs(expected).max())  # K has 1e-11 of rounding
    # Large displacements and cables that go slack change little where the load is a thousandth.
    small = rest_state(bridge(), gravity=0.0, loads=(PointLoad(19, "y", -9.81e-3),))
    prestressed = linearise(bridge(), rest_state(bridge(), gravity=0.0)).stiffness.toarray()
    about_rest = small - rest_state(bridge(), gravity=0.0)
    tangent = np.linalg.solve(prestressed, load[free] / 1000)
    np.testing.assert_allclose(about_rest[free], tangent, atol=1e-4 * np.abs(tangent).max())


def test_prestress_keeps_the_deck_level_under_its_weight() -> None:
    structure = bridge()
    state = rest_state(structure).reshape(55, 3)
    assert np.abs(state[:29, 1]).max() < 1e-3  # a millimetre in six metres
    np.testing.assert_allclose(state[:29, 1], state[28::-1, 1], atol=1e-9)  # mirrored
    np.testing.assert_allclose(state[:29, 0], -state[28::-1, 0], atol=1e-9)


def test_weight_lowers_the_sway_by_five_percent() -> None:
    loaded = natural_modes(linearise(bridge(), rest_state(bridge())), 10).frequencies
    ratio = loaded / natural_modes(linearise(bridge()), 10).frequencies
    assert ratio[0] == pytest.approx(0.95, abs=0.005)
    assert (np.abs(ratio[1:] - 1) < 0.01).all()


def test_rayleigh_damping_is_that_of_the_authors_simulation() -> None:
    ratios = natural_modes(linearise(bridge()), 4).damping_ratio
    np.testing.assert_allclose(ratios[:2], 0.003, rtol=1e-3)  # the two frequencies are given to five digits
    assert (np.diff(ratios[1:]) > 0).all()


@pytest.mark.parametrize("divisions", [2, 3])
def test_refinement_changes_the_first_modes_little(divisions: int) -> None:
    found = natural_modes(linearise(bridge().refined(divisions)), 10).frequencies
    # One element a member is off by (k h)^4 / 1440, at most 3e-5 for the tenth.
    np.testing.assert_allclose(found, FREQUENCIES, rtol=1e-4)
