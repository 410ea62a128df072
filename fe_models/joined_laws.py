"""Force laws on the degrees of freedom that move: what each acts along, and their forces in a motion."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import ForceLaw, LawWithMemory, MemorylessLaw
from fe_models.dof_map import DofMap
from fe_models.errors import raise_faults

Joined = tuple[tuple[ForceLaw, FloatArray], ...]
"""Force laws with their coefficients (free,)."""


def joined_laws(dofs: DofMap, laws: tuple[ForceLaw, ...]) -> Joined:
    """Return each law with its coefficients; one end of two may be held, and counts as the ground."""
    joined, faults = [], []
    for law in laws:
        missing = _missing(dofs, law)
        faults += missing
        if missing:
            continue
        full = dofs.pull(law.pulls)
        if full.any() and not full[dofs.free].any():
            place = " and ".join(f"node {node} is held in {direction}" for node, direction, _ in law.pulls)
            faults.append(f"{law.kind}: {place}; join a node that moves")
        joined.append((law, full[dofs.free]))
    raise_faults(faults)
    return tuple(joined)


def _missing(dofs: DofMap, law: ForceLaw) -> list[str]:
    """Return a fault for each degree of freedom that a law acts on and the model has not."""
    faults = []
    for node, direction, _ in law.pulls:
        try:
            dofs.row(node, direction)
        except KeyError as missing:
            faults.append(f"{law.kind}: {missing.args[0]}")
    return faults


def law_forces(laws: Joined, x: FloatArray, v: FloatArray, z: FloatArray, time: FloatArray) -> FloatArray:
    """Return the forces (realisation, time, free) of laws; ``z``: of those with memory, (realisation, time, law)."""
    total, remembered = np.zeros_like(x), iter(np.moveaxis(z, -1, 0))
    for law, pull in laws:
        if isinstance(law, LawWithMemory):
            total += np.asarray(law.force_of(next(remembered)))[..., None] * pull
        elif isinstance(law, MemorylessLaw):
            total += np.asarray(law.force(x @ pull, v @ pull, time))[..., None] * pull
    return total
