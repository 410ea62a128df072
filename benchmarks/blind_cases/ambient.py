"""A linear structure under unknown forces, as wind and traffic: coloured noise, another at each place, for minutes.

    q'' + D q' + Omega^2 q = Phi^T f(t)

with D the modal damping, coupling included, and f straight between fine samples. In the complex modes of that equation
each of them is a recursion of first order with the force's values at both ends of a step: exact, and as fast as a
digital filter.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig, inv
from scipy.signal import butter, lfilter

from benchmarks.blind_cases.marching import damping_coupling
from fe_models.arrays import ComplexArray, FloatArray
from fe_models.linear import LinearModel, ModalModel
from fe_models.recordings import QUANTITIES, Sensor
from fe_models.structure import Direction

SETTLING = 2.0  # times the slowest decay: so long before a recording the forces begin, when the structure is at rest
POLES_AT_ONCE = 16  # of a long record: what is held in memory of their forces


@dataclass(frozen=True)
class UnknownForces:
    """Independent forces at ``places`` (node, direction), of the ``sizes`` (place,) in N: white noise behind a low-pass
    of first order at ``corner`` Hz. Drawn from their ``seed``.
    """

    places: tuple[tuple[int, Direction], ...]
    sizes: FloatArray
    corner: float
    seed: int

    def values(self, samples: int, rate: float) -> FloatArray:
        """Return so many samples of them at a ``rate`` (Hz), (time, place)."""
        white = np.random.default_rng(self.seed).standard_normal((samples, len(self.places)))
        coloured = lfilter(*butter(1, self.corner, fs=rate), white, axis=0)
        return np.asarray(coloured * self.sizes / coloured.std(axis=0))


def ambient_motion(
    linear: LinearModel,
    modal: ModalModel,
    forces: UnknownForces,
    sensors: tuple[Sensor, ...],
    duration: float,
    rate: float,
) -> FloatArray:
    """Return what the ``sensors`` would show without noise, (time, sensor), at a ``rate`` (Hz) for a ``duration`` (s).

    ``modal``: the modes that are followed, with their own damping ratios; what couples them comes from the ``linear``
    model.
    """
    roots, shown, pushed, direct = _first_order(linear, modal, forces, sensors)
    settling = round(SETTLING * rate / float(np.min(-roots.real)))
    values = forces.values(settling + round(duration * rate) + 1, rate)
    motion = values @ direct
    weight = np.where(roots.imag > 0, 2.0, 1.0)  # of a pair one root stands for both
    kept = np.flatnonzero(roots.imag >= 0)
    for begin in range(0, len(kept), POLES_AT_ONCE):
        some = kept[begin : begin + POLES_AT_ONCE]
        inputs = values @ pushed[some].T  # (time, root)
        for column, number in enumerate(some):
            states = _recursion(roots[number], inputs[:, column], 1 / rate)
            motion += weight[number] * (states[:, None] * shown[:, number]).real
    return np.asarray(motion[settling:])


def _first_order(
    linear: LinearModel, modal: ModalModel, forces: UnknownForces, sensors: tuple[Sensor, ...]
) -> tuple[ComplexArray, ComplexArray, ComplexArray, FloatArray]:
    """Return the roots (root,), what each sensor shows of them (sensor, root), how forces push them (root, place), and
    what sensors show of forces themselves (place, sensor).
    """
    count, dofs = len(modal.omega), modal.dofs
    damping = np.diag(2 * modal.damping_ratio * modal.omega) + damping_coupling(linear, modal)
    zeros, ones = np.zeros((count, count)), np.eye(count)
    roots, states = eig(np.block([[zeros, ones], [-np.diag(modal.omega**2), -damping]]))
    pulls = np.column_stack([modal.shapes[dofs.row(node, direction)] for node, direction in forces.places])
    pushed = inv(states)[:, count:] @ pulls
    seen = np.array([modal.shapes[dofs.row(sensor.node, str(sensor.direction))] for sensor in sensors])
    shown = np.zeros((len(sensors), 2 * count), dtype=complex)
    direct = np.zeros((len(forces.places), len(sensors)))
    for number, sensor in enumerate(sensors):
        order = QUANTITIES.index(sensor.quantity)
        shown[number] = seen[number] @ states[:count] * roots**order
        if order == 2:  # an acceleration feels forces at once
            direct[:, number] = seen[number] @ pulls
    return roots, shown, pushed, direct


def _recursion(root: complex, force: ComplexArray, step: float) -> ComplexArray:
    """Return x (time,) of x' = root x + force, straight between samples a ``step`` (s) apart, from rest."""
    turn = root * step
    grown = np.exp(turn)
    first, second = (grown - 1) / turn, (grown - 1 - turn) / turn**2
    return np.asarray(lfilter([step * second, step * (first - second)], [1.0, -grown], force))
