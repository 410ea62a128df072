"""The modes of a recording as evidence: frequencies, damping ratios, shapes at the sensors, and their covariance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from fe_models.mode_estimate import ModeEstimate
from hybrid.diagnosis.modal.config import COMBINATION, LISTED
from hybrid.diagnosis.modal.mode_values import (
    FREQUENCY,
    RATIO,
    ModeValues,
    quantities_of,
    shape_parts,
    value_count,
    values_of_modes,
)
from hybrid.identification.identified_modes import IdentifiedModes


@dataclass(frozen=True)
class MeasuredModes:
    """The modes of one recording, by its ``name``.

    ``log_omega`` (mode,) of rad/s; damping ``ratios`` (mode,); complex ``shapes`` (mode, sensor) of any scale and
    phase. ``covariance`` (mode, value, value) of their values, see `mode_values`. ``shown`` (mode,): whose shape is
    known; None: of all.
    """

    name: str
    log_omega: FloatArray
    ratios: FloatArray
    shapes: ComplexArray
    covariance: FloatArray
    shown: BoolArray | None = None

    @staticmethod
    def listed(name: str, modes: Sequence[ModeEstimate], sensors: int) -> "MeasuredModes":
        """Return modes that somebody identified; what was not has the usual error, or any value at all."""
        omega = np.array([2 * np.pi * mode.frequency for mode in modes])
        frequency_errors = [mode.frequency_std or LISTED.frequency_error * mode.frequency for mode in modes]
        ratios = [LISTED.unknown_ratio if mode.damping_ratio is None else mode.damping_ratio for mode in modes]
        known = [mode.damping_ratio is not None for mode in modes]
        ratio_errors = [
            (mode.damping_std or LISTED.ratio_error * max(ratio, LISTED.unknown_ratio)) if given else LISTED.any_ratio
            for mode, ratio, given in zip(modes, ratios, known, strict=True)
        ]
        shapes = [np.ones(sensors) if mode.shape is None else mode.shape for mode in modes]
        shape_errors = [
            LISTED.any_shape
            if mode.shape is None
            else mode.shape_std or LISTED.shape_error * float(np.abs(mode.shape).max())
            for mode in modes
        ]
        log_omega_variance = np.square(frequency_errors) / np.square([mode.frequency for mode in modes])
        shape_variance = np.square(shape_errors)
        by_quantity = np.column_stack([log_omega_variance, np.square(ratio_errors), shape_variance, shape_variance])
        covariance = np.array([np.diag(own) for own in by_quantity[:, quantities_of(sensors)]])
        shown = np.array([mode.shape is not None for mode in modes], dtype=bool)
        return MeasuredModes(name, np.log(omega), np.array(ratios), np.array(shapes, dtype=complex), covariance, shown)

    @staticmethod
    def of(name: str, found: IdentifiedModes) -> "MeasuredModes":
        """Return what was identified from a recording, without lines that are sums or multiples of others."""
        modes = found.take(~are_combinations(found))
        return MeasuredModes(name, np.log(np.abs(modes.roots)), modes.ratios, modes.shapes.T, modes.scatter)

    @property
    def has_shape(self) -> BoolArray:
        """Which modes' shapes are known, (mode,)."""
        return np.ones(self.count, dtype=bool) if self.shown is None else self.shown

    @property
    def count(self) -> int:
        """Number of modes."""
        return len(self.log_omega)

    def values_over(self, reference: IntArray) -> ModeValues:
        """Return the values of all modes over their ``reference`` (mode,) entries.

        z = v / v_ref has dz = (dv - z dv_ref) / v_ref, which turns the covariance.
        """
        every, sensors = np.arange(self.count), self.shapes.shape[1]
        by = self.shapes[every, reference][:, None]
        z = self.shapes / by
        turned = np.zeros((self.count, value_count(sensors), value_count(sensors)))
        turned[:, FREQUENCY, FREQUENCY] = turned[:, RATIO, RATIO] = 1.0
        real, imaginary = shape_parts(sensors)
        slope = np.zeros((self.count, sensors, sensors), dtype=complex)
        slope[:, range(sensors), range(sensors)] = 1 / by
        slope[every, :, reference] -= z / by
        turned[:, real, real], turned[:, real, imaginary] = slope.real, -slope.imag
        turned[:, imaginary, real], turned[:, imaginary, imaginary] = slope.imag, slope.real
        values = values_of_modes(self.log_omega, self.ratios, z)
        return ModeValues(values, turned @ self.covariance @ turned.swapaxes(1, 2))


def are_combinations(found: IdentifiedModes) -> BoolArray:
    """Return which lines (mode,) are at a multiple, a sum or a difference of the frequencies of far stronger ones."""
    energy, known = found.energy, (found.frequencies, found.frequency_errors)
    far_stronger = [np.flatnonzero(own < COMBINATION.max_energy_share * energy) for own in energy]
    return np.array([is_combined_of(line, strong, *known) for line, strong in enumerate(far_stronger)], dtype=bool)


def is_combined_of(line: int, others: IntArray, frequency: FloatArray, error: FloatArray) -> bool:
    """Return whether a line is at a multiple, a sum or a difference of the frequencies of ``others``, all by their
    numbers; ``frequency`` and its standard deviation, ``error``, (line,).
    """
    i, j = (index.ravel() for index in np.meshgrid(others, others))
    expected = np.concatenate([frequency[i] + frequency[j], np.abs(frequency[i] - frequency[j])])
    sigma = np.sqrt(error[line] ** 2 + np.tile(error[i] ** 2 + error[j] ** 2, 2))
    reach = np.maximum(COMBINATION.max_distance_sigma * sigma, COMBINATION.max_relative_distance * frequency[line])
    return bool(np.any((np.abs(frequency[line] - expected) < reach) & (expected > 0)))
