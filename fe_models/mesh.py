"""The finite elements that a structure is computed with: each beam split into equal parts, all else as drawn."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from fe_models.dof_map import DofMap
from fe_models.dofs import structure_dofs
from fe_models.structure import Beam, Structure


@dataclass(frozen=True)
class FiniteElement:
    """One finite element; ``parent`` is the number, from 1, of the structure's element that it is (a part of).

    ``nodes`` are mesh node numbers, from 1, in the direction of the parent; a spring to ground has one.
    """

    nodes: tuple[int] | tuple[int, int]
    parent: int


@dataclass(frozen=True)
class Mesh:
    """``coordinates`` (node, 2) in m, the ``elements``, and the degrees of freedom of all nodes.

    The nodes of the structure come first and keep their numbers; the inner nodes of refined beams follow, element by
    element, from the first node of each towards its last.
    """

    coordinates: FloatArray
    elements: tuple[FiniteElement, ...]
    dofs: DofMap


def mesh(structure: Structure) -> Mesh:
    """Split each beam of a valid structure (see `structure_checks`) into ``structure.divisions`` finite elements."""
    divisions = structure.divisions
    fractions = np.arange(1, divisions)[:, None] / divisions
    corners = np.array(structure.nodes, dtype=float).reshape(-1, 2)
    inner: list[FloatArray] = []
    elements: list[FiniteElement] = []
    next_node = len(corners) + 1
    for number, element in enumerate(structure.elements, start=1):
        if not isinstance(element, Beam):
            elements.append(FiniteElement(element.nodes, number))
            continue
        first, last = element.nodes
        start, end = corners[first - 1], corners[last - 1]
        inner.append(start + fractions * (end - start))
        chain = (first, *range(next_node, next_node + divisions - 1), last)
        elements.extend(FiniteElement(pair, number) for pair in pairwise(chain))
        next_node += divisions - 1
    return Mesh(np.vstack([corners, *inner]), tuple(elements), structure_dofs(structure))


def nodes_in_finer(structure: Structure, times: int) -> IntArray:
    """Return which nodes (node,), from 1, those of a structure's mesh are where each element is split ``times``."""
    corners, divisions = len(structure.nodes), structure.divisions
    beams = sum(isinstance(element, Beam) for element in structure.elements)
    first = corners + np.arange(beams)[:, None] * (times * divisions - 1)
    inner = first + times * np.arange(1, divisions)
    return np.concatenate([np.arange(1, corners + 1), inner.ravel()])
