"""Where an axial force can be: taken off at both ends of an element, or passed on to the next one."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.built_in.bridge import bridge
from fe_models.causes import AxialForce
from fe_models.causes.equilibrium import is_borne
from fe_models.causes.known import Known
from fe_models.causes.places import Motion
from fe_models.recordings import Assumptions, Dataset
from fe_models.sections import round_wire, square_tube
from fe_models.structure import Beam, Cable, Element, Spring, Structure, Support
from hybrid.diagnosis.nominal.structure_model import nominal_model_of

TUBE = square_tube("tube", 2.1e11, 7850.0, 0.1, 0.004)
WIRE = round_wire("wire", 2.1e11, 7850.0, 0.01)


def column(*more: Element, upper: float = 0.0) -> Structure:
    """A clamped column of two elements, its ``upper`` one leaning by so much (m), with a node beside its top."""
    nodes = ((0.0, 0.0), (0.0, 2.0), (upper, 4.0), (3.0, 4.0))
    held = Support(1, ("x", "y", "rz"))
    return Structure("column", nodes, (Beam((1, 2), TUBE), Beam((2, 3), TUBE), *more), supports=(held,))


def resting(lean: float = 0.0) -> Structure:
    """A column of two elements that is held along it below and half-way up, and sideways at its top."""
    nodes = ((0.0, 0.0), (lean, 2.0), (2 * lean, 4.0), (3.0, 4.0))
    held = Support(1, ("y",)), Support(2, ("y",)), Support(3, ("x",))
    return replace(column(), nodes=nodes, supports=held)


@pytest.mark.parametrize(
    ("structure", "borne"),
    [
        (column(), [False, False]),  # the support bears it below, but nothing above
        (column(Beam((3, 4), TUBE)), [False, False, False]),
        (column(Cable((2, 4), WIRE), Beam((3, 4), TUBE)), [True, True, True, True]),
        (column(Spring((2,), "y", 1e3)), [True, False, False]),
        (column(Spring((2,), "x", 1e3)), [False, False, False]),
        (column(Spring((2,), "rz", 1e3)), [False, False, False]),
        (column(upper=0.5), [True, False]),  # a kink of 14 degrees
        (column(upper=0.3), [False, False]),  # of 9 degrees
        (resting(), [True, False]),
        (resting(lean=0.5), [True, True]),  # 14 degrees off what holds the top
        (resting(lean=0.3), [True, False]),  # 9 degrees
    ],
    ids=["free", "beam", "cable", "spring", "across", "twisting", "knee", "kink", "roller", "leaning", "hardly"],
)
def test_element_bears_an_axial_force_where_both_ends_are_held(structure: Structure, borne: list[bool]) -> None:
    assert [is_borne(structure, element) for element in structure.elements] == borne


def test_axial_forces_are_weighed_by_what_bears_them() -> None:
    structure = bridge()
    nominal = nominal_model_of(Dataset(structure, 100.0, (), (), assumptions=Assumptions()))
    still = Motion(np.zeros((2, len(nominal.dofs))), np.zeros((2, len(nominal.dofs))))
    found = {tuple(c.location["elements"]): c.weight for c in AxialForce.candidates(Known(nominal, still))}
    assert {numbers for numbers, weight in found.items() if len(numbers) == 1 and weight == 1.0} == {
        (number,)
        for number in range(53, 61)  # the cables: deck and towers carry theirs on from element to element
    }
    assert all(weight == (1.0 if len(numbers) > 1 or numbers[0] > 52 else 0.1) for numbers, weight in found.items())
    assert tuple(range(29, 41)) in found
