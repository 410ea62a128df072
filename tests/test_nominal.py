"""The modal model that a dataset assumes."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh

from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import ModalDamping, PointDamper
from fe_models.errors import InputError
from fe_models.four_dof_data import paper_sensors
from fe_models.modes import natural_modes
from fe_models.nominal import nominal_modes
from fe_models.recordings import Assumptions, Dataset

CHAIN = Dataset(four_dof(), 10.0, paper_sensors(), ())


def test_by_default_it_is_the_structures_own() -> None:
    own = natural_modes(linearise(four_dof()), 4)
    found = nominal_modes(CHAIN, 10)
    np.testing.assert_array_equal(found.omega, own.omega)
    np.testing.assert_array_equal(found.damping_ratio, own.damping_ratio)


def test_modes_above_the_lowpass_are_left_out() -> None:
    """The chain's frequencies are 0.039, 0.174, 0.276 and 0.340 Hz."""
    assert len(nominal_modes(replace(CHAIN, lowpass=0.3), 10).omega) == 3
    assert len(nominal_modes(replace(CHAIN, sampling_rate=0.4), 10).omega) == 2


def test_the_dataset_may_ask_for_fewer_modes_than_the_program() -> None:
    assert len(nominal_modes(replace(CHAIN, assumptions=Assumptions(modes=2)), 4).omega) == 2
    assert len(nominal_modes(CHAIN, 3).omega) == 3


def test_a_modal_model_stands_in_for_the_structures() -> None:
    other = replace(natural_modes(linearise(four_dof()), 4), omega=np.array([0.2, 1.0, 1.7, 2.2]))
    given = replace(CHAIN, assumptions=Assumptions(modal_model=other, damping_ratio=0.01))
    found = nominal_modes(given, 10)
    np.testing.assert_array_equal(found.omega, other.omega)
    np.testing.assert_array_equal(found.damping_ratio, np.full(4, 0.01))


def test_a_modal_model_in_any_order_keeps_no_mode_above_the_lowpass() -> None:
    """Shapes and damping ratios stay with their frequencies (0.039, 0.174, 0.276 and 0.340 Hz)."""
    own = natural_modes(linearise(four_dof()), 4)
    order = [3, 1, 0, 2]
    mixed = replace(own, omega=own.omega[order], damping_ratio=np.arange(4.0) / 100, shapes=own.shapes[:, order])
    found = nominal_modes(replace(CHAIN, lowpass=0.25, assumptions=Assumptions(modal_model=mixed)), 4)
    np.testing.assert_array_equal(found.omega, own.omega[[1, 0]])
    np.testing.assert_array_equal(found.shapes, own.shapes[:, [1, 0]])
    np.testing.assert_array_equal(found.damping_ratio, [0.01, 0.02])
    listed = Assumptions(modal_model=mixed, damping_ratio=(0.1, 0.2, 0.3, 0.4))
    np.testing.assert_array_equal(
        nominal_modes(replace(CHAIN, lowpass=0.25, assumptions=listed), 4).damping_ratio, [0.2, 0.3]
    )


def test_a_model_of_matrices_gives_its_own_modes() -> None:
    """By scipy's dense solver; a mode's damping ratio is phi^T C phi / (2 omega), with C = 0.1 I here."""
    model = linearise(four_dof())
    squares, shapes = eigh(model.stiffness.toarray(), model.mass.toarray())
    found = nominal_modes(replace(CHAIN, model=model), 10)
    np.testing.assert_allclose(found.omega, np.sqrt(squares), rtol=1e-10)
    np.testing.assert_allclose(found.damping_ratio, 0.1 * (shapes**2).sum(axis=0) / 2 / found.omega, rtol=1e-10)


def test_damping_ratios_are_one_for_all_or_one_each() -> None:
    listed = replace(CHAIN, assumptions=Assumptions(damping_ratio=(0.01, 0.02, 0.03, 0.04, 0.05)))
    np.testing.assert_array_equal(nominal_modes(listed, 4).damping_ratio, [0.01, 0.02, 0.03, 0.04])
    with pytest.raises(InputError, match="lists 2 values for 4 modes"):
        nominal_modes(replace(CHAIN, assumptions=Assumptions(damping_ratio=(0.01, 0.02))), 4)


def test_no_mode_below_the_lowpass_is_a_fault() -> None:
    with pytest.raises(InputError, match=r"no natural frequency lies below 0.02 Hz"):
        nominal_modes(replace(CHAIN, lowpass=0.02), 4)


def test_assumed_damping_stands_for_the_structures_own_and_leaves_its_effects() -> None:
    """So that a found damper or damping ratio is not lost when the extended structure is taken as the model."""
    effects = (ModalDamping((2,), 0.07), PointDamper((1,), "x", 0.3))
    assumed = Assumptions(damping_ratio=0.01)
    found = nominal_modes(replace(CHAIN, model=four_dof().with_effects(*effects), assumptions=assumed), 4)
    own = natural_modes(linearise(four_dof()), 4)
    damper = 0.3 * own.shapes[0] ** 2 / (2 * own.omega)
    np.testing.assert_allclose(found.damping_ratio, np.where(np.arange(4) == 1, 0.07, 0.01 + damper), rtol=1e-6)
