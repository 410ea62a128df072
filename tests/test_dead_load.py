"""Small motions under weight and prestress: the tangent at rest, a closed form, and a column that would fall."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.causes import DeadLoad
from fe_models.errors import InputError
from fe_models.modes import natural_modes
from fe_models.statics import rest_state
from fe_models.structure import PointMass
from tests.problems import TIMBER, cantilever


@pytest.mark.parametrize("share", [0.5, 1.0])
def test_dead_load_gives_the_drawn_structure_its_tangent_at_rest(share: float) -> None:
    drawn, loaded = bridge(), bridge().with_effects(DeadLoad(share))
    rest, plain, found = (linearise(*of) for of in ((drawn, rest_state(drawn)), (drawn,), (loaded,)))
    expected = plain.stiffness + share * (rest.stiffness - plain.stiffness)
    assert abs(found.stiffness - expected).max() < 1e-12 * abs(expected).max()
    assert abs(plain.stiffness - expected).max() > 1e-5 * abs(expected).max()
    assert abs(found.damping - plain.damping).max() == 0.0
    again = linearise(loaded, rest_state(loaded)).stiffness  # at rest it is there already
    assert abs(again - rest.stiffness).max() < 1e-12 * abs(expected).max()


def test_weight_hanging_from_a_rod_stiffens_it() -> None:
    """A massless clamped rod with a mass m below: omega^2 = k(P) / m with k(P) = P / (L (1 - tanh(a) / a)), P = m g,
    a = L sqrt(P / (E I)).
    """
    length, P = 2.0, 5 * TIMBER.bending_stiffness / 2.0**2
    rod = replace(
        cantilever(length, 16, replace(TIMBER, density=0.0)),
        nodes=((0.0, 0.0), (0.0, -length)),
        point_masses=(PointMass(2, P / 9.81),),
    )
    a = length * np.sqrt(P / TIMBER.bending_stiffness)
    exact = np.sqrt(P / (length * (1 - np.tanh(a) / a)) / (P / 9.81))
    found = natural_modes(linearise(rod.with_effects(DeadLoad())), 1).omega[0]
    assert found == pytest.approx(exact, rel=1e-3)  # order 2 of 16 elements


def test_dead_load_of_a_structure_that_would_fall_is_refused() -> None:
    column = replace(cantilever(divisions=4), nodes=((0.0, 0.0), (0.0, 2.0)), point_masses=(PointMass(2, 1e5),))
    linearise(column)
    with pytest.raises(InputError, match="state at rest"):
        linearise(column.with_effects(DeadLoad()))
