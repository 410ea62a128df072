"""Where an axial force can be: taken off at both ends of an element, or passed on to the next one."""

from dataclasses import replace

import pytest

from fe_models.bridge import bridge
from fe_models.sections import round_wire, square_tube
from fe_models.structure import Beam, Cable, Element, Spring, Structure, Support
from hybrid.diagnosis.causes.equilibrium import is_borne

TUBE = square_tube("tube", 2.1e11, 7850.0, 0.1, 0.004)
WIRE = round_wire("wire", 2.1e11, 7850.0, 0.01)


def column(*more: Element, upper: float = 0.0) -> Structure:
    """A clamped column of two elements, its ``upper`` one leaning by so much (m), with a node beside its top."""
    nodes = ((0.0, 0.0), (0.0, 2.0), (upper, 4.0), (3.0, 4.0))
    held = Support(1, ("x", "y", "rz"))
    return Structure("column", nodes, (Beam((1, 2), TUBE), Beam((2, 3), TUBE), *more), supports=(held,))


@pytest.mark.parametrize(
    ("structure", "borne"),
    [
        (column(), [False, False]),  # the support bears it below, but nothing above
        (column(Beam((3, 4), TUBE)), [False, False, False]),
        (column(Cable((2, 4), WIRE), Beam((3, 4), TUBE)), [True, True, True, True]),
        (column(Spring((2, 4), "y", 1e3)), [True, False, False]),
        (column(upper=2.0), [True, False]),  # a knee
        (column(upper=0.1), [False, False]),  # hardly one
        (replace(column(), supports=(Support(1, ("y",)), Support(2, ("y",)), Support(3, ("x",)))), [True, False]),
    ],
    ids=["free top", "beam", "cable", "spring", "knee", "kink", "roller across"],
)
def test_element_bears_an_axial_force_where_both_ends_are_held(structure: Structure, borne: list[bool]) -> None:
    assert [is_borne(structure, element) for element in structure.elements] == borne


def test_cables_of_the_bridge_bear_axial_forces_by_themselves() -> None:
    structure = bridge()
    borne = [number for number, element in enumerate(structure.elements, start=1) if is_borne(structure, element)]
    assert borne == list(range(53, 61))  # deck and towers carry theirs on from element to element
