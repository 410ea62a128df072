"""Whether every part of a structure hangs together and is held: what would make its stiffness matrix singular.

Each connected piece is checked as a rigid body: its supports and springs to ground must stop all motions that the
directions of its nodes allow. Mechanisms inside a piece (a hinge too many) show only when its modes are computed.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from fe_models.arrays import FloatArray
from fe_models.structure import Beam, Direction, Spring, Structure

MOTION_NAMES = {"x": "sway in x", "y": "move in y", "rz": "turn"}
MAX_NODES_NAMED = 6  # in one fault line; more would hide what it says


def connection_faults(structure: Structure) -> list[str]:
    """Return faults of loose nodes, loose pieces and free rotations of a structure whose parts are each sound."""
    faults = []
    joined = {node for element in structure.elements for node in element.nodes}
    loose = [node for node in range(1, len(structure.nodes) + 1) if node not in joined]
    if loose:
        faults.append(f"{_name_nodes(loose)}: no element joins there; connect or remove")
    held = _held(structure)
    for members in _pieces(structure, joined):
        faults.extend(_rigid_motion_faults(structure, members, held))
    faults.extend(_free_rotation_faults(structure))
    return faults


def _pieces(structure: Structure, joined: set[int]) -> list[list[int]]:
    """Return the nodes of each connected piece, in order; nodes that no element joins are left out."""
    pairs = np.array([element.nodes for element in structure.elements if len(element.nodes) == 2], dtype=np.int64)
    first, last = pairs.reshape(-1, 2).T - 1
    count = len(structure.nodes)
    graph = coo_array((np.ones(len(first)), (first, last)), shape=(count, count))
    pieces = dict[int, list[int]]()
    for node, piece in enumerate(connected_components(graph, directed=False)[1].tolist(), start=1):
        if node in joined:
            pieces.setdefault(piece, []).append(node)
    return [pieces[piece] for piece in sorted(pieces)]


def _held(structure: Structure) -> dict[int, list[Direction]]:
    """Return the directions in which each node is held by supports and springs to ground."""
    held = dict[int, list[Direction]]()
    for support in structure.supports:
        held.setdefault(support.node, []).extend(support.directions)
    for element in structure.elements:
        if isinstance(element, Spring) and len(element.nodes) == 1:
            held.setdefault(element.nodes[0], []).append(element.direction)
    return held


def _rigid_motion_faults(structure: Structure, members: list[int], held: dict[int, list[Direction]]) -> list[str]:
    """Return one fault if the piece made of the nodes ``members`` can move as a rigid body."""
    points = np.array([structure.nodes[node - 1] for node in members], dtype=float)
    centre, size = points.mean(axis=0), max(float(np.ptp(points, axis=0).max()), 1e-300)
    motions = _rigid_motions(structure.directions, is_point=len(members) == 1)
    rows = [
        _constraint(direction, (np.array(structure.nodes[node - 1]) - centre) / size)[motions]
        for node in members
        for direction in held.get(node, ())
    ]
    constraints = np.array(rows).reshape(-1, len(motions))
    # Lengths are in units of the piece's size, so that singular values compare; 1e-9 is far above their rounding.
    stopped = int(np.linalg.matrix_rank(constraints, tol=1e-9)) if rows else 0
    if stopped == len(motions):
        return []
    if not rows:
        return [f"{_name_nodes(members)}: joined to each other but held nowhere; add a support or a spring to ground"]
    alone = [index for index in range(len(motions)) if not constraints[:, index].any()]
    free = [MOTION_NAMES[("x", "y", "rz")[motions[index]]] for index in alone] or ["turn about a point"]
    return [f"{_name_nodes(members)}: held too little, free to {' and '.join(free)} as a rigid body; add a support"]


def _rigid_motions(directions: tuple[Direction, ...], is_point: bool) -> list[int]:
    """Return which of translation in x (0), in y (1) and rotation (2) a piece, or a single node, can take part in."""
    motions = [index for index, direction in enumerate(("x", "y")) if direction in directions]
    turns = "rz" in directions or (len(motions) == 2 and not is_point)
    return [*motions, 2] if turns else motions


def _constraint(direction: str, point: FloatArray) -> FloatArray:
    """Return how much a unit translation in x, in y and a unit rotation move ``point`` in ``direction``, (3,)."""
    x, y = point
    return np.array({"x": (1.0, 0.0, -y), "y": (0.0, 1.0, x), "rz": (0.0, 0.0, 1.0)}[direction])


def _free_rotation_faults(structure: Structure) -> list[str]:
    """Return one fault with the nodes whose rotation nothing resists, as where only cables meet."""
    if "rz" not in structure.directions:
        return []
    stiff = {node for e in structure.elements if isinstance(e, Beam) for node in e.nodes}
    stiff |= {node for e in structure.elements if isinstance(e, Spring) and e.direction == "rz" for node in e.nodes}
    stiff |= {support.node for support in structure.supports if "rz" in support.directions}
    joined = {node for element in structure.elements for node in element.nodes}
    free = sorted(joined - stiff)
    return [f"{_name_nodes(free)}: nothing resists rotation there; add a support in rz"] if free else []


def _name_nodes(nodes: list[int]) -> str:
    shown = ", ".join(map(str, nodes[:MAX_NODES_NAMED]))
    more = len(nodes) - MAX_NODES_NAMED
    return f"node{'s' if len(nodes) > 1 else ''} {shown}" + (f" and {more} more" if more > 0 else "")
