"""The modal model that a dataset assumes."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.assembly import linearise
from fe_models.errors import InputError
from fe_models.four_dof import four_dof, paper_sensors
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


def test_damping_ratios_are_one_for_all_or_one_each() -> None:
    listed = replace(CHAIN, assumptions=Assumptions(damping_ratio=(0.01, 0.02, 0.03, 0.04, 0.05)))
    np.testing.assert_array_equal(nominal_modes(listed, 4).damping_ratio, [0.01, 0.02, 0.03, 0.04])
    with pytest.raises(InputError, match="lists 2 values for 4 modes"):
        nominal_modes(replace(CHAIN, assumptions=Assumptions(damping_ratio=(0.01, 0.02))), 4)


def test_no_mode_below_the_lowpass_is_a_fault() -> None:
    with pytest.raises(InputError, match=r"no natural frequency lies below 0.02 Hz"):
        nominal_modes(replace(CHAIN, lowpass=0.02), 4)
