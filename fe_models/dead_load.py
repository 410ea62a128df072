"""What a dead load adds to K: the tangent at rest under weight and prestress, less that of the drawn geometry."""

from scipy.sparse import csr_array

from fe_models.dofs import DofMap
from fe_models.effects import DeadLoad
from fe_models.items import equal_items, summed
from fe_models.mesh import mesh
from fe_models.statics import rest_state
from fe_models.structure import Structure


def has_dead_load(structure: Structure) -> bool:
    """Return whether a structure's small motions feel its weight. To add zeros to K would be to round it anew."""
    return any(isinstance(effect, DeadLoad) for effect in structure.effects)


def dead_load_stiffness(structure: Structure, dofs: DofMap) -> csr_array:
    """Return share (K_rest - K) over the free ones of ``dofs``, zero where the structure has no `DeadLoad`.

    `InputError` where there is no state at rest: it may buckle under its own weight.
    """
    shares = [effect.share for effect in structure.effects if isinstance(effect, DeadLoad)]
    if not shares:
        size = int(dofs.free.sum())
        return csr_array((size, size))
    parts, rest = mesh(structure), rest_state(structure)
    at_rest, drawn = (summed(equal_items(structure, parts, state), dofs)[2] for state in (rest, None))
    return csr_array(sum(shares) * (at_rest - drawn))
