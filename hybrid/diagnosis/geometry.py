"""What a frame's geometry adds to its linear motion: stretching of what bends, shortening of what sways.

The nominal model exerts these forces itself (Exudyn), so they are no cause of their own, and they are small. They are
quadratic and cubic in the modal coordinates; modes that are not followed give way statically.
"""

from dataclasses import dataclass, replace
from itertools import combinations_with_replacement

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.recordings import Sensor
from fe_models.structure import Cable, Structure
from hybrid.diagnosis.driven import History, driven, free_form, motion_of
from hybrid.diagnosis.hypothesis import Hypothesis
from hybrid.diagnosis.plant import Plant

LARGE = 0.02  # of the largest: modes whose displacements are smaller count once at most in a product
SAMPLES = 4  # states at which forces are taken, for each of the products
SPREAD = 1.5  # times the rms of a motion: how far these states go
SETTLING = 4  # steps in which the modes that are not followed give way
SETTLED = 0.05  # of the largest displacement: what the last of them may still change
LINEAR = 1e-3  # of elastic forces at a hundredth of the motion: geometric ones are less


@dataclass(frozen=True)
class Geometry:
    """Geometric forces in the nominal modes that are followed, on top of the elastic ones.

    ``weighted`` (dof, mode): M phi, which picks modal coordinates and distributes modal forces; ``size`` (mode,): rms of
    the coordinates; ``products`` (product, mode): powers; ``forces`` (product, mode): modal forces for each product of
    coordinates in units of ``size``.
    """

    weighted: FloatArray
    size: FloatArray
    products: FloatArray
    forces: FloatArray

    def at(self, coordinates: FloatArray) -> FloatArray:
        """Return the modal forces (..., mode) at modal ``coordinates`` (..., mode)."""
        return np.asarray(_products(coordinates / self.size, self.products) @ self.forces)

    def added(
        self,
        hypothesis: Hypothesis,
        theta: FloatArray,
        states: FloatArray,
        samples: int,
        sensors: tuple[Sensor, ...],
        rate: float,
        faulty: tuple[int, ...],
    ) -> FloatArray:
        """Return what the channels (recording, time, sensor) of a motion from ``states`` (recording, state) gain.

        To first order in the forces: those along the motion without them. ``faulty``: as in `Hypothesis.system`.
        """
        system, n = hypothesis.system(theta[None], sensors, rate, faulty), hypothesis.size
        reduced, form = hypothesis.reduced(theta[None]), free_form(system, n)
        shapes = reduced.shapes[0]  # (dof, vector)
        motion = motion_of(system, states, samples)
        now, between = (self.at(part[..., :n] @ (self.weighted.T @ shapes).T) for part in (motion.now, motion.between))
        moved = np.linalg.solve(reduced.mass[0], shapes.T @ self.weighted)  # (vector, mode)
        accelerations = np.array([sensor.quantity == "acceleration" for sensor in sensors])
        shown = hypothesis.plant.rows(sensors) @ shapes @ moved
        direct = np.where(accelerations[:, None], shown, 0.0) * system.gain[0][:, None]
        feed = np.zeros((system.A.shape[1], len(self.size)))
        feed[n : 2 * n] = moved
        return sum(
            (
                driven(form, 0, feed[:, i], direct[:, i], History(now[..., i], between[..., i]), system.step)
                for i in range(len(self.size))
            ),
            np.zeros((len(states), samples, len(sensors))),
        )


def geometry_of(plant: Plant, states: FloatArray, rng: np.random.Generator) -> Geometry | None:
    """Return the geometric forces about motions like those of the nominal ``states`` (..., state).

    None of a chain, which has none, and where they do not settle: something buckles, or there is no motion.
    """
    if plant.kept is None:
        return None
    from fe_models.exudyn_forces import InternalForces  # loads Exudyn only where it is needed

    shapes = plant.modes[1]
    weighted = plant.mass @ shapes
    picked = weighted.T @ Hypothesis(plant).reduced(np.zeros((1, len(plant.spread)))).shapes[0]
    motion = states[..., : plant.size].reshape(-1, plant.size) @ picked.T
    size = np.sqrt(np.mean(motion**2, axis=0))
    if not size.all():
        return None
    products = _powers(size * np.abs(shapes).max(axis=0))
    forces, free = InternalForces(_bars(plant.structure)), plant.dofs.free[:, None]
    still = np.zeros(len(plant.dofs))

    def beyond(u: FloatArray) -> FloatArray:
        exerted = np.stack([forces(column, still) for column in u.T], axis=1)  # (dof, state)
        return np.where(free, exerted + plant.stiffness @ u, 0.0)

    count = SAMPLES * len(products)
    coordinates = SPREAD * size * rng.standard_normal((count, len(size)))
    u, bent, change = shapes @ coordinates.T, np.zeros((len(shapes), count)), np.inf
    slight = beyond(0.01 * u[:, :1])
    if np.linalg.norm(shapes.T @ slight) > LINEAR * np.linalg.norm(plant.modes[0] ** 2 * 0.01 * coordinates[0]):
        return None
    for _ in range(SETTLING):
        felt = beyond(u + bent)
        given = plant.static(felt)
        given -= shapes @ (weighted.T @ given)
        change, bent = float(np.abs(given - bent).max()), given
    if not change < SETTLED * float(np.abs(u).max()):
        return None
    rows = _products(coordinates / size, products)
    fitted = np.linalg.lstsq(rows, (shapes.T @ felt).T, rcond=None)[0]
    return Geometry(weighted, size, products, fitted)


def _powers(displacements: FloatArray) -> FloatArray:
    """Return the quadratic and cubic products (product, mode) with one factor at most of modes that hardly move."""
    count, large = len(displacements), displacements > LARGE * displacements.max()
    found = []
    for degree in (2, 3):
        for factors in combinations_with_replacement(range(count), degree):
            if sum(not large[i] for i in factors) <= 1:
                found.append(np.bincount(factors, minlength=count))
    return np.array(found)


def _products(scaled: FloatArray, powers: FloatArray) -> FloatArray:
    """Return products (..., product) of ``scaled`` coordinates (..., mode) with ``powers`` (product, mode)."""
    found = np.ones((*scaled.shape[:-1], len(powers)))
    for mode in range(scaled.shape[-1]):
        for degree in (1, 2, 3):
            found[..., powers[:, mode] == degree] *= scaled[..., mode, None] ** degree
    return found


def _bars(structure: Structure) -> Structure:
    """Return the structure with cables as the linear model has them: bars that carry nothing at rest."""
    elements = [replace(e, prestress=0.0, tension_only=False) if isinstance(e, Cable) else e for e in structure.elements]
    return replace(structure, elements=tuple(elements))
