"""Where an axial force can be at all: along a member it passes from element to element until something takes it off."""

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.structure import Element, Spring, Structure

IN_LINE = 0.98  # cosine of the angle up to which an element carries on the axial force of its neighbour
ACROSS = 0.2  # of that up to which a support holds nothing along an element


def is_borne(structure: Structure, element: Element) -> bool:
    """Return whether an axial force in this element alone is taken off at both ends: by a support that holds along it,
    or by an element that is not in line.
    """
    return all(_is_taken_off(structure, element, node) for node in element.nodes)


def _is_taken_off(structure: Structure, element: Element, node: int) -> bool:
    along = _line(structure, element)
    held = {direction for support in structure.supports if support.node == node for direction in support.directions}
    if any(abs(share) > ACROSS for share, direction in zip(along, "xy", strict=True) if direction in held):
        return True
    others = [other for other in structure.elements if node in other.nodes and other is not element]
    return any(isinstance(other, Spring) or abs(_line(structure, other) @ along) < IN_LINE for other in others)


def _line(structure: Structure, element: Element) -> FloatArray:
    """Return the unit vector (x, y) along an element; zero where it has no length."""
    vector = np.subtract(structure.nodes[element.nodes[-1] - 1], structure.nodes[element.nodes[0] - 1])
    return np.asarray(vector / max(float(np.hypot(*vector)), np.finfo(float).tiny))
