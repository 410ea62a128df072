"""The modes that a hypothesis predicts at the sensors: of its state space, with all that its causes do to them.

Gains and delays of sensors, dashpots, supports that give way and a simulation's own time steps are all in the state
space's eigenvalues s and in what its sensors show of the eigenvectors; nothing here knows of any kind of cause.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from fe_models.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from hybrid.diagnosis.modal.mode_values import values_of_modes
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.config import STATE_SPACE
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import modal_form


@dataclass(frozen=True)
class PredictedModes:
    """``roots`` (variant, mode), rad/s, by frequency of the first variant, and ``shapes`` (variant, mode, sensor).

    ``stands`` (variant,): whether the structure does, or else buckles, and its roots and shapes mean nothing.
    """

    roots: ComplexArray
    shapes: ComplexArray
    stands: BoolArray

    @property
    def log_omega(self) -> FloatArray:
        """The logarithm of each natural frequency in rad/s, (variant, mode)."""
        return np.log(np.abs(self.roots))

    @property
    def ratios(self) -> FloatArray:
        """The damping ratios (variant, mode)."""
        return np.asarray(-self.roots.real / np.abs(self.roots))

    def values_over(self, mode: IntArray, reference: IntArray) -> FloatArray:
        """Return the values (variant, row, value) of each ``mode`` (row,), or (variant, row), its shape over its
        ``reference`` (row,) entry; see `mode_values`.
        """
        variant = np.arange(len(self.roots))[:, None]
        mode = np.broadcast_to(mode, (len(variant), np.shape(mode)[-1]))
        shapes = self.shapes[variant, mode]
        z = shapes / shapes[variant, np.arange(mode.shape[1]), reference][..., None]
        return values_of_modes(self.log_omega[variant, mode], self.ratios[variant, mode], z)


def predicted_modes(
    hypothesis: Hypothesis, thetas: FloatArray, outputs: SensorOutputs, hardly_differ: bool = False
) -> PredictedModes | None:
    """Return the modes of ``thetas`` (variant, parameter), those that all variants have that stand; None where none
    does, and of a body that moves freely.

    ``hardly_differ``: whether variants are those of a Jacobian, each near to the first.
    """
    try:
        form = modal_form(system_of(hypothesis, thetas, outputs, hardly_differ), hardly_differ)
    except np.linalg.LinAlgError:  # masses that are not positive
        return None
    if form is None or not (np.isfinite(form.roots).all() and np.isfinite(form.right).all()):
        return None
    shapes = form.right.swapaxes(1, 2)
    order = np.argsort(np.where(form.roots.imag > 0, np.abs(form.roots), np.inf), axis=1)
    roots, shapes = np.take_along_axis(form.roots, order, 1), np.take_along_axis(shapes, order[..., None], 1)
    falls = (roots.imag == 0) & (roots.real > STATE_SPACE.min_root_distance * np.abs(roots).max(axis=1, keepdims=True))
    stands = ~falls.any(axis=1)
    if not stands.any() or (hardly_differ and not stands.all()):
        return None
    vibrating = (roots.imag > 0)[stands].all(axis=0)
    found = PredictedModes(roots[:, vibrating], shapes[:, vibrating], stands)
    return _in_order(found) if hardly_differ else found


def _in_order(modes: PredictedModes) -> PredictedModes:
    """Return the modes with those of each variant in the order of the first one's: near frequencies may cross."""
    first = modes.roots[0]
    same = np.arange(len(first))
    orders = [linear_sum_assignment(np.abs(first[:, None] - roots))[1] for roots in modes.roots]
    if all((order == same).all() for order in orders):
        return modes
    index = np.array(orders)
    return PredictedModes(
        np.take_along_axis(modes.roots, index, 1), np.take_along_axis(modes.shapes, index[..., None], 1), modes.stands
    )
