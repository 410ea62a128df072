"""What the bridge does when nothing is hidden in it: the scale for whatever is hidden in it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eigvalsh

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.causes import Effect, SupportSpring
from fe_models.causes.time_integration import root
from fe_models.linear import LinearModel, ModalModel
from fe_models.matrix_changes import matrix_changes
from fe_models.recordings import Sensor
from fe_models.response import Response
from fe_models.structure import Structure

FELT_MODES = 6  # up to 14.7 Hz: those that hold most of the energy
BISECTIONS = 30
# of the stiffness that the bridge has there without the support; below it, the support is as good as lost
MIN_STIFFNESS_SHARE = 0.1


@dataclass(frozen=True)
class Scene:
    """The bridge without what is hidden (``design``), its ``model`` and all its modes (``modal``), and who sees how it
    moves (``calm``).

    ``calm``: (motion, time, dof).
    """

    design: Structure
    model: LinearModel
    modal: ModalModel
    calm: Response
    sensors: tuple[Sensor, ...]

    def rms(self, node: int, direction: str) -> tuple[float, float]:
        """Return the root mean square of displacement (m) and velocity (m/s) there."""
        u, v = (self.calm.channel(node, direction, quantity) for quantity in ("displacement", "velocity"))
        return float(np.sqrt(np.mean(u**2))), float(np.sqrt(np.mean(v**2)))

    def shape(self, node: int, direction: str) -> FloatArray:
        """Return the modes there, (felt,), mass-normalised."""
        return self.modal.shapes[self.modal.dofs.row(node, direction), :FELT_MODES]

    def moves(self, node: int, direction: str) -> bool:
        """Whether the place moves at least a tenth of what the most moving place does in some mode."""
        most = np.abs(self.modal.shapes[:, :FELT_MODES]).max(axis=0)
        return bool((np.abs(self.shape(node, direction)) > 0.1 * most).any())

    def local_stiffness(self, node: int, direction: str) -> float:
        """Return the force (N) that moves the place by 1 m."""
        dofs = self.model.dofs
        load = np.zeros(self.model.mass.shape[0])
        row = int(np.count_nonzero(dofs.free[: dofs.row(node, direction)]))
        load[row] = 1.0
        return float(1 / np.linalg.solve(self._matrices[1], load)[row])

    def damper(self, node: int, direction: str, ratio: float) -> float:
        """Return the coefficient (N s/m) that adds ``ratio`` to the damping ratio of the mode it damps most."""
        return float(ratio / np.max(self.shape(node, direction) ** 2 / (2 * self.modal.omega[:FELT_MODES])))

    def spring(self, node: int, direction: str, shift: float) -> float | None:
        """Return the stiffness (N/m) of a spring to the ground that shifts a frequency by that much: see `amount`."""
        return self.amount(SupportSpring(node, direction, 1.0), shift, 1e7)  # type: ignore[arg-type]

    def steady(self, node: int, direction: str, frequency: float) -> float:
        """Return the largest rms that 1 N at ``frequency`` (Hz) brings to a sensor, relative to what it shows calm."""
        mass, stiffness, damping = self._matrices
        dofs, omega = self.model.dofs, 2 * np.pi * frequency
        load = np.zeros(len(dofs))
        load[dofs.row(node, direction)] = 1.0
        dynamic = stiffness - omega**2 * mass + 1j * omega * damping
        response = np.zeros(len(dofs), dtype=complex)
        response[dofs.free] = np.linalg.solve(dynamic, load[dofs.free]) * -(omega**2)
        shares = [abs(response[dofs.row(s.node, str(s.direction))]) / self.calm.shown(s).std() for s in self.sensors]
        return float(max(shares) / np.sqrt(2))

    def amount(self, unit: Effect, shift: float, most: float) -> float | None:
        """Return how many times the linear effect ``unit`` shifts one of the felt frequencies by the share ``shift``.

        Where even ``most`` times do less, that; None where they do less than `LEAST_SHIFT`.
        """
        free = self.model.dofs.free
        changes = matrix_changes(self.design, unit)
        dM, dK = (part.toarray()[np.ix_(free, free)] for part in (changes.mass, changes.stiffness))
        mass, stiffness, _ = self._matrices
        return _solved(lambda size: self._shift(mass + size * dM, stiffness + size * dK), shift, most)

    def support(self, node: int, direction: str, shift: float) -> float | None:
        """Return the stiffness (N/m) of a spring in a support's place that shifts a frequency by that much."""
        loose = linearise(self.design.with_effects(SupportSpring(node, direction, 0.0)))  # type: ignore[arg-type]
        mass, stiffness = loose.mass.toarray(), loose.stiffness.toarray()
        row = int(np.count_nonzero(loose.dofs.free[: loose.dofs.row(node, direction)]))

        def shift_by(compliance: float) -> float:
            sprung = stiffness.copy()
            sprung[row, row] += 1 / compliance
            return self._shift(mass, sprung)

        stiff = float(1 / np.linalg.solve(stiffness, np.eye(len(stiffness))[row])[row])  # what the place itself has
        compliance = _solved(shift_by, shift, most=1 / (MIN_STIFFNESS_SHARE * stiff))
        return None if compliance is None else 1 / compliance

    @cached_property
    def _matrices(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        return self.model.mass.toarray(), self.model.stiffness.toarray(), self.model.damping.toarray()

    def _shift(self, mass: FloatArray, stiffness: FloatArray) -> float:
        """Return the largest relative change of a felt frequency."""
        squared = eigvalsh(stiffness, mass, subset_by_index=[0, FELT_MODES - 1])
        omega = np.sqrt(np.maximum(squared, 0.0))
        return float(np.abs(omega / self.modal.omega[:FELT_MODES] - 1).max())


MIN_SHIFT = 0.003
"""Relative change of a frequency below which nobody could see it; one per cent of stiffness makes 0.005."""


def _solved(shift: Callable[[float], float], wanted: float, most: float) -> float | None:
    """Return the size at which ``shift`` (rising) is ``wanted``, by halving its logarithm."""
    largest = shift(most)
    if largest <= wanted:
        return most if largest >= MIN_SHIFT else None
    low, high = np.log(1e-10 * most), np.log(most)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if shift(float(np.exp(middle))) < wanted else (low, middle)
    return float(np.exp((low + high) / 2))


def free_motion(modal: ModalModel, q: FloatArray, p: FloatArray, time: FloatArray) -> Response:
    """Return the motion (motion, time, dof) from modal coordinates and rates, each (mode, motion), exactly."""
    count = len(q)
    pole = root(modal.omega[:count], modal.damping_ratio[:count])[:, None]
    # q(t) = Re(c exp(lambda t)) with Re c = q(0) and Re(lambda c) = q'(0)
    amplitude = q + 1j * (q * pole.real - p) / pole.imag  # (mode, motion)
    turning = np.exp(pole * time)  # (mode, time)
    parts = [
        np.einsum("dm,mk,mt->ktd", modal.shapes[:, :count], amplitude * pole**power, turning, optimize=True).real
        for power in range(3)
    ]
    return Response(time, parts[0], parts[1], parts[2], modal.dofs)
