"""Recordings of a linear model, of matrices say, by its lowest modes: let go from pulls, or driven.

Released at rest from K u0 = f, each modal coordinate moves from q(0) = phi^T f / omega^2, q'(0) = 0 by its two
exponentials (`_let_go`). Under a load, q'' + 2 xi omega q' + omega^2 q = phi^T p f(t), exact for the smooth curve
through its samples (`interpolant`); of a base that moves p = -M r and f its acceleration.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.linalg import expm

from fe_models.arrays import FloatArray
from fe_models.base_motion import BaseMotion
from fe_models.dof_map import DofMap
from fe_models.drive import Drive, drive_of
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.recording_checks import check_place, check_rates, check_sensor
from fe_models.interpolant import interpolant
from fe_models.linear import LinearModel, ModalModel
from fe_models.measurement import measure, noise_faults
from fe_models.mode_count import mode_count
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Load, Recording, Sensor
from fe_models.response import Response
from fe_models.sensing import seen
from fe_models.simulation_size import length_faults
from fe_models.statics import PointLoad
from fe_models.synthetic import OVERSAMPLING, Acquisition

MOST_MODES = 60
"""Modes that move at most: a large model has no end of them, and sensors show a few dozen."""
NO_EFFECT = "the pull would do nothing"


@dataclass(frozen=True)
class _Scene:
    """A model's ``modal`` model, the ``sensors`` and how recordings are made (``acquisition``)."""

    model: LinearModel
    modal: ModalModel
    sensors: tuple[Sensor, ...]
    acquisition: Acquisition

    def response(self, time: FloatArray, motion: Sequence[FloatArray], ground: FloatArray | None = None) -> Response:
        """Return the motion at the sensors, of displacement, velocity and acceleration (mode, time) each."""
        rows = np.flatnonzero(seen(self.modal.dofs, self.sensors).any(axis=0))
        own = self.modal.dofs
        dofs = DofMap(own.node[rows], own.direction[rows], np.ones(len(rows), dtype=bool))
        x, v, a = ((self.modal.shapes[rows] @ part).T for part in motion)
        return Response(time, x, v, a, dofs, ground)

    def recorded(self, response: Response, rng: np.random.Generator, start: float = 0.0) -> FloatArray:
        """Return what the sensors record of it, (1, time, sensor)."""
        how = self.acquisition
        return measure(response, self.sensors, how.sampling_rate, rng, how.lowpass, how.noise, start)[None]


def released_recordings(
    model: LinearModel,
    releases: Sequence[tuple[PointLoad, ...]],
    sensors: tuple[Sensor, ...],
    acquisition: Acquisition,
    duration: float,
    rng: np.random.Generator,
) -> Dataset:
    """Return one recording for each of the ``releases`` of pulls, ``duration`` (s) each; of several the last is for
    testing. `InputError` with all faults.
    """
    columns = OVERSAMPLING * len(releases) * (len(sensors) + MOST_MODES)
    faults = length_faults(duration, acquisition.sampling_rate, columns=columns)
    raise_faults([*check_linear(model, releases, sensors, acquisition), *faults])
    if not releases:
        raise InputError("there is nothing to release: give at least one pull")
    scene = _scene(model, sensors, acquisition)
    time = _times(duration + acquisition.start, acquisition)
    recordings = []
    for number, pulls in enumerate(releases, start=1):
        force = model.dofs.pull([(pull.node, pull.direction, pull.force) for pull in pulls])
        motion = _let_go(scene.modal, scene.modal.shapes.T @ force, time)
        data = scene.recorded(scene.response(time, motion), rng, acquisition.start)
        recordings.append(Recording(f"release_{number}", data, _role(number, len(releases))))
    return Dataset(model, acquisition.sampling_rate, sensors, tuple(recordings), acquisition.lowpass)


def driven_recordings(
    model: LinearModel,
    excitations: Sequence[Sequence[Load | BaseMotion]],
    sensors: tuple[Sensor, ...],
    acquisition: Acquisition,
    rng: np.random.Generator,
) -> Dataset:
    """Return one recording from rest under each of the ``excitations``, which have one value a sample; of several the
    last is for testing. `InputError` with all faults.
    """
    faults, rate = check_linear(model, (), sensors, acquisition), acquisition.sampling_rate
    drives = [
        noting(faults, f"recording {number}", drive_of, model, excitation, rate)
        for number, excitation in enumerate(excitations, start=1)
    ]
    if not excitations:
        faults.append("nothing drives the model: give loads, or a base motion")
    raise_faults(faults)
    scene, recordings = _scene(model, sensors, acquisition), []
    for number, (excitation, drive) in enumerate(zip(excitations, drives, strict=True), start=1):
        assert drive is not None  # else there were faults
        motion = _driven(scene.modal, drive, _fine(acquisition))
        time = _times(drive.duration, acquisition)
        data = scene.recorded(scene.response(time, motion, drive.ground(time)), rng)
        loads = tuple(item for item in excitation if isinstance(item, Load))
        role = _role(number, len(excitations))
        recordings.append(Recording(f"driven_{number}", data, role, loads, excitation="measured", base=drive.base))
    return Dataset(model, rate, sensors, tuple(recordings), acquisition.lowpass)


def check_linear(
    model: LinearModel,
    releases: Sequence[tuple[PointLoad, ...]],
    sensors: tuple[Sensor, ...],
    acquisition: Acquisition,
) -> list[str]:
    """Return the faults of what is to be simulated, before time is spent on it."""
    faults = check_rates(acquisition.sampling_rate, acquisition.lowpass)
    nodes = len(model.coordinates)
    for sensor in sensors:
        faults += [f"sensor {sensor.name!r}: {fault}" for fault in check_sensor(sensor, model.dofs, nodes)]
    for pull in (pull for pulls in releases for pull in pulls):
        faults += [f"pull: {fault}" for fault in check_place(pull.node, pull.direction, model.dofs, nodes, NO_EFFECT)]
    return faults + noise_faults(acquisition.noise, sensors)


def _scene(model: LinearModel, sensors: tuple[Sensor, ...], acquisition: Acquisition) -> _Scene:
    """Return the scene with the modes that move: those in the band of the recordings, and some beyond."""
    return _Scene(model, natural_modes(model, min(MOST_MODES, mode_count(model))), sensors, acquisition)


def _times(duration: float, acquisition: Acquisition) -> FloatArray:
    fine = _fine(acquisition)
    return np.arange(round(duration * acquisition.sampling_rate) * fine + 1) / (fine * acquisition.sampling_rate)


def _fine(acquisition: Acquisition) -> int:
    """Return into how many steps a sample is divided, so that a low-pass acts before sampling."""
    return OVERSAMPLING if acquisition.lowpass else 1


def _let_go(modal: ModalModel, forces: FloatArray, time: FloatArray) -> list[FloatArray]:
    """Return displacement, velocity and acceleration (mode, time) of modes that modal ``forces`` (mode,) held at rest
    until t = 0, of any damping ratio.

    The roots s = omega (-xi +- sqrt(xi^2 - 1)) are complex below critical damping, equal at it, real beyond it. With
    D(t) = (exp(s1 t) - exp(s2 t)) / (s1 - s2), which is t exp(s1 t) where they are equal,

        q = q(0) (exp(s1 t) - s1 D),   q' = -omega^2 q(0) D,   q'' = -omega^2 q(0) (exp(s1 t) + s2 D)
    """
    omega, ratio = modal.omega[:, None], modal.damping_ratio[:, None]
    apart = np.sqrt(ratio.astype(complex) ** 2 - 1)
    slow, fast = -omega / (ratio + apart), -omega * (ratio + apart)  # s1 s2 = omega^2: nothing cancels in the slow one
    one, gap = np.exp(slow * time), (fast - slow) * time  # (mode, time)
    mean = np.ones_like(gap)  # of exp over the gap, (exp(z) - 1) / z
    np.divide(np.expm1(gap), gap, out=mean, where=gap != 0)
    two = time * one * mean
    parts = (one - slow * two) / omega**2, -two, -(one + fast * two)
    return [forces[:, None] * part.real for part in parts]


def _driven(modal: ModalModel, drive: Drive, fine: int) -> list[FloatArray]:
    """Return displacement, velocity and acceleration (mode, time) of modes from rest, in ``fine`` steps to a sample.

    Forces are polynomials over each step h, with derivatives g_p at its begin. They add sum h phi_p+1(A h) F h^p g_p to
    a state z' = A z + F g, all in the first rows of one matrix exponential (Al-Mohy and Higham 2011, th. 2.1).
    """
    course, step = interpolant(drive.values), 1 / (drive.sampling_rate * fine)
    at = np.arange((len(drive.values) - 1) * fine + 1) / fine  # whole numbers at the samples, where polynomials join
    orders = course.k + 1
    feed = drive.pulls @ modal.shapes  # (force, mode)
    courses = np.stack([course(at[:-1], order) / fine**order @ feed for order in range(orders)], axis=1)
    pushed, found = course(at) @ feed, []
    for mode, (omega, ratio) in enumerate(zip(modal.omega, modal.damping_ratio, strict=True)):
        A = np.array([[0.0, 1.0], [-(omega**2), -2 * ratio * omega]])
        whole = np.zeros((2 + orders, 2 + orders))
        whole[:2, :2], whole[1, 2] = A * step, step
        whole[2:-1, 3:] += np.eye(orders - 1)
        over = expm(whole)[:2]
        state = np.zeros((len(at), 2))
        for number, push in enumerate(courses[:, :, mode] @ over[:, 2:].T):
            state[number + 1] = over[:, :2] @ state[number] + push
        found.append([state[:, 0], state[:, 1], pushed[:, mode] + state @ A[1]])
    return list(np.array(found).swapaxes(0, 1))


def _role(number: int, count: int) -> Literal["train", "test"]:
    return "test" if number == count > 1 else "train"
