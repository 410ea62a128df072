"""The geometric forces of the nominal structure, from Exudyn, as polynomials of its modal coordinates.

Modes that are not followed give way statically: a stretched deck draws its ends together. Without that its stretching
would be far too stiff.
"""

from itertools import combinations_with_replacement

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from fe_models.mechanisms import factorise
from hybrid.diagnosis.nominal.config import GEOMETRY
from hybrid.diagnosis.nominal.finer_mesh import ElasticMesh, finer_mesh, times_finer
from hybrid.diagnosis.nominal.geometry import Geometry, products
from hybrid.diagnosis.nominal.nominal_model import NominalModel


def geometries_of(nominal: NominalModel, motion: FloatArray, rng: np.random.Generator) -> tuple[Geometry, ...]:
    """Return the geometric forces about motions like ``motion`` (..., dof): what a beam exerts and, where that is not
    alike, what the nominal model's own elements do, on which recordings may have been simulated.

    None of a chain, which has none; without motion; and where they do not settle, as of what buckles.
    """
    omega, shapes = nominal.modes
    weighted = np.asarray(nominal.mass @ shapes)
    size = np.sqrt(np.mean((motion @ weighted).reshape(-1, len(omega)) ** 2, axis=0))
    if nominal.kept is None or not size.all():
        return ()
    powers = _powers(size * np.abs(shapes).max(axis=0))
    coordinates = GEOMETRY.reach_rms * size * rng.uniform(-1, 1, (GEOMETRY.states_per_product * len(powers), len(size)))
    scaled, found = products(coordinates / size, powers), list[Geometry]()
    for times in sorted({times_finer(nominal), 1}, reverse=True):
        mesh = finer_mesh(nominal, times)
        found_forces = _forces_and_bends(mesh, omega, coordinates)
        if found_forces is None:
            return ()
        fitted = np.asarray(np.linalg.lstsq(scaled, np.hstack(found_forces), rcond=None)[0], dtype=float)
        forces, bends = np.split(fitted, [len(size)], axis=1)
        found.append(Geometry(weighted, size, powers, forces, bends[:, mesh.rows]))
    off, beams = found[-1].forces - found[0].forces, found[0].forces
    return tuple(found[:1] if np.linalg.norm(off) <= GEOMETRY.max_mesh_difference * np.linalg.norm(beams) else found)


def _forces_and_bends(
    mesh: ElasticMesh, omega: FloatArray, coordinates: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Return the geometric modal forces (state, mode) at modal ``coordinates`` (state, mode), all else giving way, and
    how far that does (state, dof). ``omega`` (mode,): natural frequencies, rad/s.
    """
    from fe_models.exudyn.internal_forces import InternalForces  # loads Exudyn only where it is needed

    shapes, still = mesh.shapes, np.zeros(len(mesh.dofs))
    forces, free, rows = InternalForces(mesh.structure.without_prestress()), mesh.dofs.free, mesh.dofs.free_rows
    held = factorise(mesh.stiffness[rows][:, rows])

    def beyond(u: FloatArray) -> FloatArray:
        exerted = np.stack([forces(column, still) for column in u.T], axis=1)  # (dof, state)
        return np.where(free[:, None], exerted + mesh.stiffness @ u, 0.0)

    u = shapes @ coordinates.T  # (dof, state)
    slight = shapes.T @ beyond(0.01 * u[:, :1])
    if np.linalg.norm(slight) > GEOMETRY.max_tangent_error * np.linalg.norm(omega**2 * 0.01 * coordinates[0]):
        return None  # the linear model is not the tangent of what Exudyn has
    felt, bent = beyond(u), np.zeros_like(u)
    for _ in range(GEOMETRY.max_iterations):
        given = mesh.dofs.expand(held.solve(felt[free]))
        given -= shapes @ (mesh.weighted.T @ given)
        change, bent = np.abs(given - bent).max(), given
        felt = beyond(u + bent)
        if change <= GEOMETRY.max_relative_change * np.abs(bent).max():
            return np.asarray(felt.T @ shapes), np.asarray(bent.T)
    return None


def _powers(displacements: FloatArray) -> IntArray:
    """Return the quadratic and cubic products (product, mode), these with one factor at most of modes that hardly move.

    What is twice as fast may meet a mode of that frequency, however little there is of it.
    """
    count, large = len(displacements), displacements > GEOMETRY.small_mode_share * displacements.max()
    return np.array(
        [
            np.bincount(factors, minlength=count)
            for degree in (2, 3)
            for factors in combinations_with_replacement(range(count), degree)
            if degree == 2 or sum(not large[i] for i in factors) <= 1
        ]
    )
