"""What is uncertain as a whole: named groups of any kind of element, all other beams together, the rest one by one."""

from dataclasses import replace

import pytest

from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import MassChange, StiffnessChange
from fe_models.errors import InputError
from fe_models.files.structure_file import structure_from_text, structure_text
from fe_models.structure import Beam, Cable, PointMass, Spring, Structure, Support
from fe_models.structure_checks import require_structure
from fe_models.uncertain_parts import uncertain_parts
from tests.problems import TIMBER, WIRE

FRAME = Structure(
    "frame",
    ((0.0, 0.0), (0.0, 3.0), (4.0, 3.0), (4.0, 0.0)),
    (
        Beam((1, 2), TIMBER),
        Beam((2, 3), TIMBER, "roof"),
        Beam((3, 4), TIMBER),
        Cable((1, 3), WIRE, group="cable"),
        Cable((2, 4), WIRE, group="cable"),
        Cable((1, 3), WIRE, tension_only=False),
        Spring((2,), "x", 100.0, "roof"),
        Spring((2,), "y", 100.0, "soil"),
        Spring((3,), "y", 100.0, "soil"),
        Spring((3,), "x", 100.0),
        Spring((2, 3), "x", 100.0),
    ),
    (PointMass(2, 5.0), PointMass(3, 6.0)),
    supports=(Support(1, ("x", "y")), Support(4, ("x", "y"))),
)


def parts_of(structure: Structure, quantity: str) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    return [(part.elements, part.nodes) for part in uncertain_parts(structure) if part.quantity == quantity]


def test_a_named_group_is_one_part_whatever_its_elements_are() -> None:
    stiffnesses = [elements for elements, _ in parts_of(FRAME, "stiffness")]
    assert stiffnesses == [(1, 3), (2, 7), (4, 5), (6,), (8, 9), (10,), (11,)]
    assert parts_of(FRAME, "mass") == [((1, 3), (2, 3)), ((2,), ())]  # the frame's nodes first; springs have no mass


def test_the_built_in_structures_have_the_parts_that_they_had() -> None:
    cables = [((number,), ()) for number in range(53, 61)]
    groups = [tuple(range(1, 29)), tuple(range(29, 41)), tuple(range(41, 53))]
    assert parts_of(bridge(), "stiffness") == [*((group, ()) for group in groups), *cables]
    assert [elements for elements, _ in parts_of(bridge(), "mass")] == groups
    assert parts_of(four_dof(), "stiffness") == [((number,), ()) for number in range(1, 5)]
    assert parts_of(four_dof(), "mass") == [((), (number,)) for number in range(1, 5)]


def test_a_group_that_is_called_as_its_kind_is_kept_in_its_file() -> None:
    again = structure_from_text(structure_text(FRAME), "frame.toml")
    assert again == FRAME
    assert [element.group for element in again.elements] == [element.group for element in FRAME.elements]


def test_a_change_of_a_group_finds_its_elements() -> None:
    softer = StiffnessChange((), 0.5, "soil").extend(FRAME).elements
    assert [element.stiffness for element in softer if isinstance(element, Spring)] == [100.0, 50.0, 50.0, 100.0, 100.0]
    each = StiffnessChange((), (0.5, 0.25), "soil").extend(FRAME).elements  # one for each, in the order of the file
    assert [element.stiffness for element in each if isinstance(element, Spring)] == [100.0, 50.0, 25.0, 100.0, 100.0]
    with pytest.raises(InputError, match="factor lists 3 values for 2 places; give one each"):
        require_structure(replace(FRAME, effects=(StiffnessChange((), (0.5, 0.25, 1.0), "soil"),)))
    heavier = MassChange((), 2.0, "roof").extend(FRAME)
    assert heavier.elements[1].section.density == 2 * TIMBER.density  # type: ignore[union-attr]  # a beam
    assert heavier.elements[6:] == FRAME.elements[6:]  # a spring's stiffness is no mass
    every = StiffnessChange((), 0.5, "beam").extend(FRAME).elements  # nobody's name: all beams without one
    assert [number for number, element in enumerate(every, start=1) if element not in FRAME.elements] == [1, 3]
    with pytest.raises(InputError, match="there is no group 'wall'; the groups are beam, roof, cable, soil, spring"):
        require_structure(replace(FRAME, effects=(StiffnessChange((), 0.5, "wall"),)))
