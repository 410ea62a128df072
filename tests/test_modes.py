"""Natural modes against closed forms, their convergence, and limits: no mass, many degrees of freedom, all modes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fe_models import modes
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.damping import full_damping, rayleigh_damping
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.modes import mac, natural_modes
from fe_models.structure import Beam, Damping, PointMass, Structure, Support
from tests.problems import CANTILEVER_ROOTS, TIMBER, bending_frequencies, cantilever


def bending(structure: Structure, count: int) -> FloatArray:
    """Return the lowest frequencies (Hz) of the modes that bend, those along the beam left out."""
    result = natural_modes(linearise(structure), 2 * count)
    across = np.abs(result.shapes[1::3]).max(axis=0) > 1e-6
    return result.frequencies[across][:count]


def test_cantilever_frequencies_converge_with_order_four() -> None:
    exact = bending_frequencies(CANTILEVER_ROOTS, 2.0)
    errors = np.array([bending(cantilever(divisions=n), 3) / exact - 1 for n in (8, 16, 32)])  # (refinement, mode)
    assert (errors > 0).all()  # consistent mass and conforming shapes approach from above
    orders = np.log2(errors[:-1] / errors[1:])
    # Cubic shapes: order 4 in the frequency; the next term, of order 6, takes 0.07 off the third mode on 8 elements.
    np.testing.assert_allclose(orders, 4.0, atol=0.1, err_msg=f"observed orders {orders}")


def test_simply_supported_beam() -> None:
    structure = replace(cantilever(divisions=16), supports=(Support(1, ("x", "y")), Support(2, ("y",))))
    exact = bending_frequencies(tuple(np.pi * n for n in (1, 2, 3)), 2.0)
    errors = bending(structure, 3) / exact - 1
    # The leading error of cubic shapes with consistent mass is (k h)^4 / 1440; the next is (k h)^2 / 30 of it.
    np.testing.assert_allclose(errors, (np.pi * np.array([1, 2, 3]) / 16) ** 4 / 1440, rtol=0.02)


@pytest.mark.parametrize("divisions", [1, 6])
def test_modes_diagonalise_mass_and_stiffness(divisions: int) -> None:
    model = linearise(bridge().refined(divisions))
    result = natural_modes(model, 12)
    shapes = result.shapes[model.dofs.free]
    np.testing.assert_allclose(shapes.T @ (model.mass @ shapes), np.eye(12), atol=1e-8)  # eigsh's own tolerance
    stiffness = shapes.T @ (model.stiffness @ shapes) / np.outer(result.omega, result.omega)
    np.testing.assert_allclose(stiffness, np.eye(12), atol=1e-7)  # K of the refined bridge has 1e-9 of rounding left
    assert not result.shapes[~model.dofs.free].any()
    assert (np.diff(result.omega) > 0).all()


def test_shift_and_invert_agrees_with_the_full_solution(monkeypatch: pytest.MonkeyPatch) -> None:
    model = linearise(bridge())
    full = natural_modes(model, 20)
    monkeypatch.setattr(modes, "LARGEST_DENSE_SOLVE", 0)
    few = natural_modes(model, 20)
    np.testing.assert_allclose(few.omega, full.omega, rtol=1e-9)  # both leave about 1e-11
    np.testing.assert_allclose(few.shapes, full.shapes, atol=1e-5)  # also the same signs; modes 8 and 9 lie close


def test_all_modes_of_the_bridge() -> None:
    model = linearise(bridge())
    result = natural_modes(model, 153)
    shapes = result.shapes[model.dofs.free]
    # w_153^2 / w_1^2 = 2e8 roundings
    np.testing.assert_allclose(shapes.T @ (model.mass @ shapes), np.eye(153), atol=1e-6)


def test_sign_makes_the_first_large_translation_positive() -> None:
    result = natural_modes(linearise(bridge()), 10)
    translations = result.dofs.direction != "rz"
    for shape in result.shapes.T:
        moved = np.where(translations, shape, 0.0)
        first = np.argmax(np.abs(moved) >= 0.999 * np.abs(moved).max())
        assert shape[first] > 0


def massless_column() -> Structure:
    """A cantilever without mass of its own but 5 kg at each of three nodes: 6 modes in 9 degrees of freedom."""
    light = replace(TIMBER, density=0.0)
    nodes = tuple((0.5 * i, 0.0) for i in range(4))
    return replace(
        cantilever(),
        nodes=nodes,
        elements=tuple(Beam((i, i + 1), light) for i in (1, 2, 3)),
        point_masses=tuple(PointMass(i, 5.0) for i in (2, 3, 4)),
    )


@pytest.mark.parametrize("largest_dense", [0, 400])
def test_rotations_without_mass_add_no_modes(largest_dense: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(modes, "LARGEST_DENSE_SOLVE", largest_dense)
    model = linearise(massless_column())
    # The same by static condensation: the rotations follow the translations.
    moving, turning = model.mass.diagonal() > 0, model.mass.diagonal() == 0
    K = model.stiffness.toarray()
    across = K[np.ix_(moving, turning)]
    condensed = K[np.ix_(moving, moving)] - across @ np.linalg.solve(K[np.ix_(turning, turning)], across.T)
    expected = np.sqrt(np.linalg.eigvalsh(condensed / 5.0))
    found = natural_modes(model, 4).omega
    np.testing.assert_allclose(found, expected[:4], rtol=1e-9)  # roundings; K spans five decades
    with pytest.raises(InputError, match="only 6 have mass"):
        natural_modes(model, 7)


@pytest.mark.slow
def test_modes_of_a_hundred_thousand_degrees_of_freedom_are_those_of_few() -> None:
    coarse = natural_modes(linearise(bridge().refined(4)), 20)
    model = linearise(bridge().refined(640))
    fine = natural_modes(model, 20)
    assert model.mass.shape[0] > 99_000
    # From 4 to 640 elements the true frequencies move by 2e-5 at most; rounding in K leaves 1e-4, see `mechanisms`.
    np.testing.assert_allclose(fine.frequencies, coarse.frequencies, rtol=5e-4)


def test_damping_ratios_of_rayleigh_modal_and_both() -> None:
    structure = cantilever(divisions=4)
    plain = natural_modes(linearise(structure), 5)
    two = (plain.frequencies[0], plain.frequencies[1])
    rayleigh = rayleigh_damping(0.02, *two)
    found = natural_modes(linearise(replace(structure, damping=rayleigh)), 5)
    np.testing.assert_allclose(found.damping_ratio[:2], 0.02, rtol=1e-9)
    expected = rayleigh.mass_factor / (2 * plain.omega) + rayleigh.stiffness_factor * plain.omega / 2
    np.testing.assert_allclose(found.damping_ratio, expected, rtol=1e-9)
    both = linearise(replace(structure, damping=replace(rayleigh, modal_ratios=(0.01, 0.03))))
    np.testing.assert_allclose(
        natural_modes(both, 5).damping_ratio, expected + np.array([0.01, 0.03, 0.03, 0.03, 0.03]), rtol=1e-9
    )


def test_modal_ratios_as_a_matrix_give_back_the_ratios() -> None:
    model = linearise(replace(massless_column(), damping=Damping(modal_ratios=(0.01, 0.05))))
    result = natural_modes(model, 6)
    shapes = result.shapes[model.dofs.free]
    modal = shapes.T @ full_damping(model) @ shapes
    expected = np.diag(2 * np.array([0.01, *[0.05] * 5]) * result.omega)
    np.testing.assert_allclose(modal, expected, atol=1e-9 * expected.max())  # roundings


@given(scale=st.floats(1e-6, 1e6), sign=st.sampled_from([-1, 1]), seed=st.integers(0, 99))
@settings(deadline=None)
def test_mac_ignores_scale_and_sign(scale: float, sign: int, seed: int) -> None:
    shapes = np.random.default_rng(seed).standard_normal((20, 3))
    criterion = mac(shapes, sign * scale * shapes)
    np.testing.assert_allclose(np.diag(criterion), 1.0, rtol=1e-12)
    assert (criterion < 1 + 1e-12).all()
    assert (criterion >= 0).all()


def test_mac_of_orthogonal_shapes_is_zero() -> None:
    np.testing.assert_array_equal(mac(np.eye(4)[:, :2], np.eye(4)[:, 1:3]), [[0.0, 0.0], [1.0, 0.0]])


@pytest.mark.parametrize("count", [0, 154])
def test_refuses_counts_that_the_model_does_not_have(count: int) -> None:
    with pytest.raises(InputError, match="153 free degrees of freedom"):
        natural_modes(linearise(bridge()), count)


def test_refuses_unusable_matrices_with_all_faults() -> None:
    model = linearise(cantilever())
    broken: LinearModel = replace(model, mass=-model.mass, stiffness=model.stiffness[:2])
    with pytest.raises(InputError) as caught:
        natural_modes(broken, 1)
    assert len(caught.value.faults) == 1  # M's sign is judged only once all shapes fit
    assert "K is 2 x 3" in caught.value.faults[0]
