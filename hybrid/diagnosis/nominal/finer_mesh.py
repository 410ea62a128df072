"""A frame on elements short enough for what its geometry adds: a long one stretches otherwise than its beam.

As a cubic it cannot keep its middle line unstretched where it bends. Linear motion hardly minds; what is of second
order is off by tens of per cent.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray, IntArray
from fe_models.assembly import linearise, unsupported
from fe_models.dof_map import DofMap
from fe_models.mesh import nodes_in_finer
from fe_models.modes import natural_modes
from fe_models.structure import Structure
from hybrid.diagnosis.nominal.config import GEOMETRY
from hybrid.diagnosis.nominal.nominal_model import NominalModel


@dataclass(frozen=True)
class ElasticMesh:
    """A mesh of a ``structure``: its ``stiffness`` (dof, dof) over all degrees of freedom ``dofs``, as if no support
    held it, the ``shapes`` (dof, mode) of the modes that are followed, mass-normalised, and ``weighted`` (dof, mode), M
    phi. ``rows``: where the nominal model's degrees of freedom are among its own.
    """

    structure: Structure
    dofs: DofMap
    stiffness: csr_array
    shapes: FloatArray
    weighted: FloatArray
    rows: IntArray


def times_finer(nominal: NominalModel) -> int:
    """Return how many times each element of a nominal model is to be split for what its geometry adds."""
    return max(
        min(ceil(GEOMETRY.min_elements_per_beam / nominal.structure.divisions), GEOMETRY.max_dofs // len(nominal.dofs)),
        1,
    )


def finer_mesh(nominal: NominalModel, times: int) -> ElasticMesh:
    """Return a frame with each element split ``times``; its modes are as many, turned like the nominal model's."""
    drawn = nominal.structure
    structure = drawn.refined(times * drawn.divisions)
    linear = linearise(structure)
    mass, _, stiffness = unsupported(structure)
    each = np.arange(len(drawn.directions))
    rows = ((nodes_in_finer(drawn, times)[:, None] - 1) * len(each) + each).ravel()
    shapes = natural_modes(linear, nominal.size).shapes
    # Modes of nearly the same frequency may be mixed otherwise: the rotation that fits best undoes that.
    left, _, right = np.linalg.svd((nominal.mass @ nominal.modes[1]).T @ shapes[rows])
    shapes = shapes @ (left @ right).T
    return ElasticMesh(structure, linear.dofs, stiffness, shapes, np.asarray(mass @ shapes), rows)
