"""Whether something takes off an axial force where its element ends: else it would pass on to the next element.

Looks one element far. What weights or friction at a node take off along a member is not counted.
"""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.structure import Element, Spring, Structure

# sine of 11.5 degrees: up to such a kink the next element takes it on, and no support holds along it
MAX_KINK_SINE = 0.2


def is_borne(structure: Structure, element: Element) -> bool:
    """Return whether an axial force in this element alone is taken off at both ends: by a support or a spring that
    holds along it, or by an element that is not in line.
    """
    return all(_is_taken_off(structure, element, node) for node in element.nodes)


def _is_taken_off(structure: Structure, element: Element, node: int) -> bool:
    along = _direction(structure, element)
    held = {direction for support in structure.supports if support.node == node for direction in support.directions}
    others = [other for other in structure.elements if node in other.nodes and other is not element]
    held |= {other.direction for other in others if isinstance(other, Spring)}
    if any(abs(share) > MAX_KINK_SINE for share, direction in zip(along, "xy", strict=True) if direction in held):
        return True
    beside = [_direction(structure, other) for other in others if not isinstance(other, Spring)]
    return any(abs(along[0] * line[1] - along[1] * line[0]) > MAX_KINK_SINE for line in beside)


def _direction(structure: Structure, element: Element) -> FloatArray:
    """Return the unit vector (x, y) along an element; zero where it has no length."""
    line = line_of(structure, element)
    return np.asarray(line / max(float(np.hypot(*line)), np.finfo(float).tiny))


def line_of(structure: Structure, element: Element) -> FloatArray:
    """Return the vector (x, y), in m, from an element's first node to its last, zero of a spring to the ground."""
    start, end = (np.array(structure.nodes[node - 1], dtype=float) for node in (element.nodes[0], element.nodes[-1]))
    return np.asarray(end - start)
