"""A structure written as matrices by groups, as a user of another program would: assembled apart for each group."""

from dataclasses import replace

from scipy.sparse import csr_array

import fe_models as fe
from fe_models.assembly import linearise, unsupported
from fe_models.linear import MatrixGroup
from fe_models.uncertain_parts import uncertain_parts


def matrices_of(structure: fe.Structure) -> fe.LinearModel:
    """Return the linear model of a structure with a group for each of its uncertain parts, named by its elements."""
    linear = linearise(structure)
    rows = linear.dofs.free_rows
    shares: dict[str, list[csr_array]] = {}
    for part in uncertain_parts(structure):
        name = "elements " + " ".join(map(str, part.elements)) if part.elements else f"mass {part.nodes[0]}"
        before, after = unsupported(structure), unsupported(part.scaled(structure, 2.0))
        own = shares.setdefault(name, [csr_array(linear.mass.shape), csr_array(linear.mass.shape)])
        position = 0 if part.quantity == "mass" else 1
        which = (0, 2)[position]
        own[position] = csr_array((after[which] - before[which])[rows][:, rows])
    groups = tuple(MatrixGroup(name, mass, stiffness) for name, (mass, stiffness) in shares.items())
    return replace(linear, groups=groups)
