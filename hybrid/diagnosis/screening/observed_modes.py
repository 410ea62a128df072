"""Natural frequencies and shapes as recordings show them: by a fit that follows these, however far its factors went."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from fe_models.arrays import TINY, FloatArray
from fe_models.recordings import derivative_orders
from hybrid.diagnosis.fitting.driven import fitted_motion
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.eigenmodes import eigenmodes
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.screening.config import MODAL_SCAN


@dataclass(frozen=True)
class PickedModes:
    """``omega`` (variant, mode), rad/s, mass-normalised ``shapes`` (variant, dof, mode), and what the measured
    ``sensors`` (variant, sensor, mode) pick of them.
    """

    omega: FloatArray
    shapes: FloatArray
    sensors: FloatArray

    def like(self, mass_shapes: FloatArray) -> "PickedModes":
        """Return the modes in the order, and with the signs, of others, given as M Phi (dof, mode)."""
        alike = mass_shapes.T @ self.shapes
        order = np.stack([linear_sum_assignment(-np.abs(part))[1] for part in alike])
        sign = np.sign(np.take_along_axis(alike, order[:, :, None], axis=2)[..., 0])

        def chosen(shapes: FloatArray) -> FloatArray:
            return np.take_along_axis(shapes, order[:, None], axis=2) * sign[:, None]

        return PickedModes(np.take_along_axis(self.omega, order, axis=1), chosen(self.shapes), chosen(self.sensors))


@dataclass(frozen=True)
class ObservedModes:
    """``omega`` (mode,), rad/s, and ``sensors`` (sensor, mode) with how well they are determined, one over variances:
    ``of_omega`` (mode,) and ``of_sensors`` (sensor, mode). ``mass_shapes``: M Phi (dof, mode).
    """

    omega: FloatArray
    sensors: FloatArray
    of_omega: FloatArray
    of_sensors: FloatArray
    mass_shapes: FloatArray

    def less(self, modes: PickedModes) -> FloatArray:
        """Return what ``modes`` leave of those seen, (variant, value), in standard deviations."""
        modes, weight = modes.like(self.mass_shapes), self.of_sensors
        scale = np.einsum("sm,sm,vsm->vm", weight, self.sensors, modes.sensors)  # initial states scale each shape
        scale = scale / (np.einsum("sm,vsm->vm", weight, modes.sensors**2) + TINY)
        shapes = np.sqrt(weight) * (self.sensors - modes.sensors * scale[:, None])
        return np.concatenate([np.sqrt(self.of_omega) * (self.omega - modes.omega), shapes.reshape(len(scale), -1)], 1)


def picked_modes(
    hypothesis: Hypothesis, thetas: FloatArray, noise_model: NoiseModel, count: int | None = None
) -> PickedModes:
    """Return the first ``count`` modes of ``thetas`` (variant, parameter), or all that are followed."""
    omega2, shapes = hypothesis.natural_modes(thetas)
    return _picked(hypothesis, omega2[:, :count], shapes[..., :count], noise_model)


def observed_modes(item: Fit, noise_model: NoiseModel) -> ObservedModes:
    """Return the modes of a fit, and how well its recordings determine them.

    A channel shows f shape q of each mode, f by its quantity. A shape is determined by the sum of (f q)^2, a frequency
    by that of (t f shape q)^2, the time t from its centre, as the phase is free.
    """
    hypothesis, theta = item.hypothesis, item.theta[None]
    reduced = hypothesis.reduced(theta)
    own_modes = eigenmodes(reduced.mass, reduced.stiffness)
    modes = _picked(hypothesis, own_modes.omega2, reduced.shapes @ own_modes.shapes, noise_model)
    omega, shapes, sensors = modes.omega[0], modes.shapes[0], modes.sensors[0]
    own = reduced.mass[0] @ own_modes.shapes[0]  # q = own^T (the followed coordinates)
    system = system_of(hypothesis, theta, noise_model.outputs)
    energy, late = np.zeros(len(omega)), np.zeros(len(omega))
    for batch, states in zip(item.batches, item.states, strict=True):
        square = (fitted_motion(system, states, batch).now[..., : len(own)] @ own) ** 2  # (time, recording, mode)
        time = np.arange(len(square))[:, None, None] / noise_model.rate
        centre = np.sum(time * square, axis=0) / (np.sum(square, axis=0) + TINY)
        energy += np.sum(square, axis=(0, 1))
        late += np.sum((time - centre) ** 2 * square, axis=(0, 1))
    order = derivative_orders(noise_model.sensors)
    factor = omega ** order[:, None] / noise_model.sigma[:, None]  # (sensor, mode)
    of_omega, of_sensors = np.sum((sensors * factor) ** 2, axis=0) * late, factor**2 * energy
    return ObservedModes(
        omega,
        sensors,
        1 / (1 / (of_omega + TINY) + (MODAL_SCAN.frequency_error * omega) ** 2),
        1 / (1 / (of_sensors + TINY) + (MODAL_SCAN.shape_error * np.abs(sensors).max(axis=0)) ** 2),
        hypothesis.nominal.mass @ shapes,
    )


def _picked(hypothesis: Hypothesis, omega2: FloatArray, shapes: FloatArray, noise_model: NoiseModel) -> PickedModes:
    sensors = hypothesis.nominal.rows(noise_model.sensors) @ shapes
    return PickedModes(np.sqrt(np.maximum(omega2, 0.0)), shapes, sensors)
