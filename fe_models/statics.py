"""States at rest under gravity, cable prestress and point loads, with large displacements and slack cables."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.laws import force_laws
from fe_models.dofs import structure_dofs
from fe_models.errors import raise_faults
from fe_models.items import gravity_load
from fe_models.mesh import mesh
from fe_models.structure import Cable, Direction, Structure
from fe_models.structure_checks import require_structure

STANDARD_GRAVITY = 9.81  # m/s^2, downwards: along -y


@dataclass(frozen=True)
class PointLoad:
    """A force (N, or N m for "rz") at a node in one direction."""

    node: int
    direction: Direction
    force: float


def rest_state(
    structure: Structure, gravity: float = STANDARD_GRAVITY, loads: tuple[PointLoad, ...] = ()
) -> FloatArray:
    """Return the displacement (dof,), in m and rad, from the drawn geometry to the state at rest.

    Equilibrium of the deformed structure under its weight (``gravity`` in m/s^2 along -y), the prestress of its cables
    and the ``loads``. `assembly.linearise` takes it for the tangent there. The force laws of effects exert nothing
    without loads: their elongations count from there; what depends on time takes no part. `InputError` where there is
    no such state.
    """
    from fe_models.exudyn.solve import static_displacement  # loads Exudyn only where it is needed

    parts = mesh(require_structure(structure))
    load = load_vector(structure, loads)
    if gravity:
        load = load + gravity_load(structure, gravity)
    laws = tuple(law for law in force_laws(structure) if not law.timed) if loads else ()
    reference = rest_state(structure, gravity) if laws else None
    taut = static_displacement(structure, parts, load, slack=False, laws=laws, reference=reference)
    if not any(isinstance(element, Cable) and element.tension_only for element in structure.elements):
        return taut
    # From the state with all cables as bars: at the drawn geometry an unstressed cable is neither taut nor slack.
    return static_displacement(structure, parts, load, True, taut, laws, reference)


def load_vector(structure: Structure, loads: tuple[PointLoad, ...]) -> FloatArray:
    """Return the loads as one vector (dof,); `InputError` where a node or direction does not exist or is held."""
    dofs = structure_dofs(structure)
    vector, faults = np.zeros(len(dofs)), []
    for load in loads:
        try:
            row = dofs.row(load.node, load.direction)
        except KeyError as missing:
            faults.append(f"load of {load.force:g} N: {missing.args[0]}; the nodes are 1 to {len(structure.nodes)}")
            continue
        if load.node > len(structure.nodes):  # one that dividing beams adds, which no drawing numbers
            known = f"the nodes are 1 to {len(structure.nodes)}"
            faults.append(f"load of {load.force:g} N: node {load.node} is none of the structure's; {known}")
            continue
        if not np.isfinite(load.force):
            faults.append(f"load at node {load.node} in {load.direction}: {load.force} is not a force")
        elif not dofs.free[row]:
            faults.append(f"load at node {load.node} in {load.direction}: a support holds the node there")
        vector[row] += load.force
    raise_faults(faults)
    return vector
