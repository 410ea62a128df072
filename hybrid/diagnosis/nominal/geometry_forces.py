"""The geometric forces of the nominal structure, from Exudyn, as polynomials of its modal coordinates.

Modes that are not followed give way statically: a stretched deck draws its ends together. Without that its stretching
would be far too stiff.
"""

from itertools import combinations_with_replacement

import numpy as np

from fe_models.dofs import FloatArray, IntArray
from hybrid.diagnosis.nominal.geometry import Geometry, products
from hybrid.diagnosis.nominal.plant import Plant

SMALL = 0.02  # of the largest: modes whose displacements are smaller count once at most in a product
STATES = 4  # at which forces are taken, for each of the products
REACH = 2.5  # times the rms of a motion: how far these states go
SETTLING = 15  # steps at most in which the modes that are not followed give way
SETTLED = 3e-3  # of what they bend: what the last step may still change
LINEAR = 1e-3  # of elastic forces at a hundredth of the motion: geometric ones are less


def geometry_of(plant: Plant, motion: FloatArray, rng: np.random.Generator) -> Geometry | None:
    """Return the geometric forces about motions like ``motion`` (..., dof).

    None of a chain, which has none; without motion; and where they do not settle, as of what buckles.
    """
    omega, shapes = plant.modes
    weighted = plant.mass @ shapes
    size = np.sqrt(np.mean((motion @ weighted).reshape(-1, len(omega)) ** 2, axis=0))
    if plant.kept is None or not size.all():
        return None
    powers = _powers(size * np.abs(shapes).max(axis=0))
    coordinates = REACH * size * rng.uniform(-1, 1, (STATES * len(powers), len(size)))
    felt = _modal_forces(plant, coordinates)
    if felt is None:
        return None
    fitted = np.linalg.lstsq(products(coordinates / size, powers), felt, rcond=None)[0]
    return Geometry(np.asarray(weighted), size, powers, np.asarray(fitted, dtype=float))


def _modal_forces(plant: Plant, coordinates: FloatArray) -> FloatArray | None:
    """Return the geometric modal forces (state, mode) at modal ``coordinates`` (state, mode), all else giving way."""
    from fe_models.exudyn_forces import InternalForces  # loads Exudyn only where it is needed

    omega, shapes = plant.modes
    weighted, still = plant.mass @ shapes, np.zeros(len(plant.dofs))
    forces, free = InternalForces(plant.structure.without_prestress()), plant.dofs.free[:, None]

    def beyond(u: FloatArray) -> FloatArray:
        exerted = np.stack([forces(column, still) for column in u.T], axis=1)  # (dof, state)
        return np.where(free, exerted + plant.stiffness @ u, 0.0)

    u = shapes @ coordinates.T  # (dof, state)
    slight = shapes.T @ beyond(0.01 * u[:, :1])
    if np.linalg.norm(slight) > LINEAR * np.linalg.norm(omega**2 * 0.01 * coordinates[0]):
        return None  # the linear model is not the tangent of what Exudyn has
    felt, bent = beyond(u), np.zeros_like(u)
    for _ in range(SETTLING):
        given = plant.static(felt)
        given -= shapes @ (weighted.T @ given)
        change, bent = np.abs(given - bent).max(), given
        felt = beyond(u + bent)
        if change <= SETTLED * np.abs(bent).max():
            return np.asarray(felt.T @ shapes)
    return None


def _powers(displacements: FloatArray) -> IntArray:
    """Return the quadratic and cubic products (product, mode) with one factor at most of modes that hardly move."""
    count, large = len(displacements), displacements > SMALL * displacements.max()
    return np.array(
        [
            np.bincount(factors, minlength=count)
            for degree in (2, 3)
            for factors in combinations_with_replacement(range(count), degree)
            if sum(not large[i] for i in factors) <= 1
        ]
    )
