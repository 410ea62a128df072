"""Places where a residual force can act: from a node to the ground, and along each element, in physical coordinates.

A free residual NN(z) is not tied to the structure: any motion that no sensor feels can be traded for another. Forces at
places are, through the mass matrix and the mode shapes: q'' = ... - G^T f(S q, S q'), with S = B Phi the elongation of
each place a unit of modal coordinate, and G = (Phi^+ M^-1 B^T)^T what a unit of its force does to q''.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.linear import LinearModel, ModalModel
from fe_models.structure import Spring, Structure


@dataclass(frozen=True)
class Connectors:
    """``names`` of the places, ``shapes`` S and ``feeds`` G, both (connector, mode)."""

    names: tuple[str, ...]
    shapes: FloatArray
    feeds: FloatArray


def complete_basis(modal: ModalModel) -> bool:
    """Return whether there are as many modes as free degrees of freedom: then any force at a place can be felt."""
    return modal.shapes.shape[1] == int(modal.dofs.free.sum())


def chain_connectors(chain: Structure, linear: LinearModel, modal: ModalModel) -> Connectors:
    """Return the places of a chain: every free degree of freedom against the ground, and every spring's two ends.

    The mass matrix is that of ``linear``; the mode shapes those of ``modal``, which need not fit each other exactly.
    """
    rows = modal.dofs.free_rows
    names = [f"node {modal.dofs.node[row]} {modal.dofs.direction[row]} to ground" for row in rows]
    pulls = list(np.eye(len(rows)))
    position = {int(row): i for i, row in enumerate(rows)}
    for element in chain.elements:
        if isinstance(element, Spring) and len(element.nodes) == 2:
            ends = [position.get(modal.dofs.row(node, element.direction)) for node in element.nodes]
            if None not in ends:
                names.append(f"node {element.nodes[0]} to node {element.nodes[1]} {element.direction}")
                pulls.append(np.eye(len(rows))[ends[1]] - np.eye(len(rows))[ends[0]])
    B = np.array(pulls)  # (connector, free)
    shapes = modal.shapes[rows]  # (free, mode)
    compliance = np.linalg.solve(linear.mass.toarray(), B.T)  # (free, connector)
    feeds = np.asarray(np.linalg.lstsq(shapes, compliance, rcond=None)[0].T, dtype=float)
    return Connectors(tuple(names), B @ shapes, feeds)
