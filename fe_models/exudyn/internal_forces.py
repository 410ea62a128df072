"""The forces inside a structure at any displacement and velocity, geometrically nonlinear, from Exudyn."""

from typing import Any

import exudyn as exu
import numpy as np

from fe_models.arrays import FloatArray
from fe_models.exudyn.item_matrices import whole_system
from fe_models.exudyn.items import Options
from fe_models.exudyn.solve import quiet_settings
from fe_models.mesh import mesh
from fe_models.structure import Structure


class InternalForces:
    """What all elements of a structure do to its nodes, force laws of effects left out; built once, called often."""

    def __init__(self, structure: Structure) -> None:
        parts = mesh(structure)
        self._system = whole_system(structure, parts, Options(structure.damping))
        self._system.mbs.Assemble()
        library: Any = exu  # whose stub file gets the solver's methods wrong
        self._solver = library.MainSolverImplicitSecondOrder()  # here only for the residual that it solves for
        self._solver.InitializeSolver(self._system.mbs, quiet_settings())
        self._size = len(parts.dofs)

    def __call__(self, displacement: FloatArray, velocity: FloatArray) -> FloatArray:
        """Return the force (dof,) in N, or N m for "rz", for ``displacement`` and ``velocity`` (dof,).

        -K u - C v for small ones. Rows at supports are without the reaction.
        """
        state = self._system.mbs.systemData
        state.SetODE2Coordinates(displacement)
        state.SetODE2Coordinates_t(velocity)
        self._solver.ComputeODE2RHS(self._system.mbs)
        return np.asarray(self._solver.GetSystemResidual())[: self._size]
