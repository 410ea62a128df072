"""How known loads and the motion of the base enter a modal model, and what sensors show of them at once.

    q'' = -Lambda q - Gamma q' + Phi^T p f(t),    Phi^T M Phi = I

with p (dof,) the pull of a load; of a base that moves, p = -M r and f its acceleration. Modes that are left out because
they lie above the recordings' band follow as the series of 1 / (omega^2 + s^2) says: in proportion to the force, then
to its second and fourth derivative (the force derivative method of Leung, 1983).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.base_motion import Along, BaseMotion
from fe_models.drive import inertia
from fe_models.errors import raise_faults
from fe_models.interpolant import Course, courses_of
from fe_models.linear import LinearModel, ModalModel
from fe_models.mechanisms import factorise
from fe_models.mode_count import mode_count
from fe_models.modes import natural_modes
from fe_models.recordings import QUANTITIES, Dataset, Recording, Sensor, of_each_quantity
from fe_models.sensing import seen
from fe_models.structure import Structure
from hybrid.known_loads.behind_lowpass import behind
from hybrid.known_loads.config import MODAL_INPUT

LoadPlace: TypeAlias = tuple[int, str]
"""Node and direction of a load."""


@dataclass(frozen=True, eq=False)
class ModalInput:
    """Loads at ``places``, then motions of the base ``along`` vectors, as they enter modes.

    ``participation`` (force, mode): q'' a unit; ``shown`` (term, sensor, force): what sensors show of a unit of the
    force, its second derivative and so on, by displacements; ``felt`` (sensor, force): what accelerometers show at
    once of the modes. ``rate`` and ``lowpass`` (Hz) of the recordings.
    """

    places: tuple[LoadPlace, ...]
    along: tuple[Along, ...]
    participation: FloatArray
    shown: FloatArray
    felt: FloatArray
    sensors: tuple[Sensor, ...]
    rate: float
    lowpass: float | None
    course: Course = "smooth"

    def courses(self, recording: Recording) -> FloatArray:
        """Return the forces and their derivatives by time in sampling intervals, (time, order, force)."""
        values = np.zeros((recording.data.shape[1], len(self.places) + len(self.along)))
        for load in recording.loads:
            values[:, self.places.index((load.node, load.direction))] += self._passed(load.values)
        for motion in recording.base:
            values[:, len(self.places) + self.along.index(motion.along)] += self._passed(motion.values)
        return courses_of(values[None], 1.0, self.course)[:, 0].transpose(1, 0, 2)

    def shown_at_once(self, recording: Recording, courses: FloatArray) -> FloatArray:
        """Return what sensors show of the forces whatever the modes' state is, (time, sensor)."""
        found = courses[:, 0] @ self.felt.T
        quantities = of_each_quantity(self.sensors)
        for term, picked in enumerate(self.shown):
            for derivative, own in enumerate(quantities):
                order = 2 * term + derivative
                found += courses[:, order] @ (own[:, None] * picked).T * self.rate**order
        for motion in recording.base:
            found += self._ground(replace(motion, values=self._passed(motion.values)))
        return found

    def _passed(self, values: FloatArray) -> FloatArray:
        return behind(values, self.rate, self.lowpass)

    def _ground(self, motion: BaseMotion) -> FloatArray:
        """Return the motion of the base itself as the sensors of the absolute motion show it, (time, sensor)."""
        samples, step = np.arange(len(motion.values)), 1 / self.rate
        velocity, displacement = motion.integrals(self.course)
        courses = np.stack([step**2 * displacement(samples), step * velocity(samples), motion.values])
        found = np.zeros((len(samples), len(self.sensors)))
        for column, sensor in enumerate(self.sensors):
            if sensor.reference == "absolute":
                found[:, column] = sensor.shown_of(motion.along) * courses[QUANTITIES.index(sensor.quantity)]
        return found


def modal_input(dataset: Dataset, modal: ModalModel, recordings: Sequence[Recording]) -> ModalInput | None:
    """Return how what drives ``recordings`` of a dataset enters the modes, None where nothing does: see `input_of`."""
    found = input_of(dataset.model, modal, dataset.sensors, dataset.sampling_rate, dataset.lowpass, recordings)
    return found and replace(found, course=dataset.load_course)


def input_of(
    model: Structure | LinearModel | None,
    modal: ModalModel,
    sensors: tuple[Sensor, ...],
    rate: float,
    lowpass: float | None,
    recordings: Sequence[Recording],
) -> ModalInput | None:
    """Return how what drives ``recordings`` enters the modes of a ``model``, None where nothing does.

    ``rate`` and ``lowpass`` (Hz) are those of the recordings. `InputError` where channels have no unit, so that forces
    in N say nothing of their size, or the base moves and no ``model`` says what mass it moves.
    """
    places = tuple(sorted({(load.node, load.direction) for each in recordings for load in each.loads}))
    along = tuple(sorted({motion.along for each in recordings for motion in each.base}))
    if not places and not along:
        return None
    faults = [
        f'sensor {sensor.name!r} has the unit "1": known forces need channels in units, as they say how far they move'
        for sensor in sensors
        if sensor.unit == "1"
    ]
    if along and model is None:
        faults.append("base motion takes the masses that it moves: give the dataset with its model")
    raise_faults(faults)
    moved = [] if model is None else [inertia(model, vector) for vector in along]
    pulls = np.array(
        [
            *(modal.dofs.pull([(node, direction, 1.0)]) for node, direction in places),
            *moved,
        ]
    )
    participation = pulls @ modal.shapes  # (force, mode)
    picked = seen(modal.dofs, sensors)
    pushed = of_each_quantity(sensors)[2]
    return ModalInput(
        places=places,
        along=along,
        participation=participation,
        shown=picked @ _left_out(model, modal, pulls, lowpass or rate / 2),
        felt=np.where(pushed[:, None], picked @ modal.shapes @ participation.T, 0.0),
        sensors=sensors,
        rate=rate,
        lowpass=lowpass,
    )


def _left_out(model: Structure | LinearModel | None, modal: ModalModel, pulls: FloatArray, band: float) -> FloatArray:
    """Return how modes that are not kept move under unit forces and their even derivatives, (term, dof, force).

    Nothing where some of these may lie within the ``band`` (Hz) of the recordings, or modes are not the model's own.
    """
    nothing = np.zeros((0, len(modal.dofs), len(pulls)))
    if model is None:
        return nothing
    linear = model if isinstance(model, LinearModel) else linearise(model)
    shapes, kept = modal.shapes[modal.dofs.free], modal.shapes.shape[1]
    if kept == len(shapes) or not _are_modes(linear, shapes, modal.omega):
        return nothing
    if kept < mode_count(linear) and natural_modes(linear, kept + 1).frequencies[-1] < band:
        return nothing
    force, factors = np.ascontiguousarray(modal.dofs.gathered(pulls.T)), factorise(linear.stiffness)
    terms = list[FloatArray]()
    for _ in range(MODAL_INPUT.left_out_terms):
        moved = factors.solve(force)
        moved = moved - shapes @ (shapes.T @ (linear.mass @ moved))
        terms.append(-moved if terms else moved)
        force = linear.mass @ terms[-1]
    return np.stack([modal.dofs.expand(term) for term in terms])


def _are_modes(linear: LinearModel, shapes: FloatArray, omega: FloatArray) -> bool:
    """Return whether mass-normalised ``shapes`` (free, mode) solve K phi = omega^2 M phi."""
    elastic = linear.stiffness @ shapes
    left = elastic - linear.mass @ shapes * omega**2
    return bool(np.linalg.norm(left) < MODAL_INPUT.max_eigen_residual * np.linalg.norm(elastic))
