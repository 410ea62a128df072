"""What a dead load adds to K: the tangent at rest under weight and prestress, less that of the drawn geometry."""

from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.causes.dead_load import dead_load_share
from fe_models.dof_map import DofMap
from fe_models.items import equal_items, scatter
from fe_models.mesh import mesh
from fe_models.statics import rest_state
from fe_models.structure import Structure


def with_dead_load(stiffness: csr_array, structure: Structure, dofs: DofMap) -> csr_array:
    """Return K over the free ones of ``dofs`` with share (K_rest - K) on top.

    The very same K where the structure has no `DeadLoad`: to add zeros would be to round it anew. `InputError` where
    there is no state at rest: it may buckle under its own weight.
    """
    share = dead_load_share(structure)
    if not share:
        return stiffness
    at_rest, drawn = (_stiffness(structure, dofs, state) for state in (rest_state(structure), None))
    return csr_array(stiffness + share * (at_rest - drawn))


def _stiffness(structure: Structure, dofs: DofMap, state: FloatArray | None) -> csr_array:
    items = equal_items(structure, mesh(structure), state)
    return scatter([(matrices.stiffness, rows) for matrices, rows in items], dofs)
