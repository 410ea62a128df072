"""The time step that a simulation needs, from the highest natural frequency that its recordings hold.

The trapezoidal rule (Newmark, constant average acceleration) replaces a circular frequency w by
2 arctan(w h / 2) / h: too low by a share of (w h)^2 / 12, for a step h, whatever the damping. To whoever compares
recordings with a model, a step too long is a structure too soft. Hughes, The Finite Element Method, 1987, section 9.3.
"""

from dataclasses import dataclass, replace
from math import atan, pi, sqrt

import numpy as np

from fe_models.assembly import linearise
from fe_models.modes import natural_modes
from fe_models.structure import Structure

MAX_FREQUENCY_ERROR = 1e-4
"""Of the highest mode in the band, relative. In a portal recorded for 12 s with 2 % noise a diagnosis sees steps that
make 26e-4 (1 ms, 28 Hz) and takes part of them for a mass; at 1e-4 and 0.3e-4 it says that nothing is wrong."""
LONGEST_STEP = 1e-3
"""s. Stops, friction and cables that go slack need short steps whatever the modes."""
FIRST_MODES = 10
"""How many modes are solved for at first, before twice as many, and so on."""


@dataclass(frozen=True)
class TimeStep:
    """A ``step`` (s) of the trapezoidal rule; ``frequency`` (Hz): of the highest mode that has to come out right."""

    step: float
    frequency: float

    @property
    def frequency_error(self) -> float:
        """By how much too low that frequency comes out, as a share of it."""
        half = pi * self.frequency * self.step
        return 1 - atan(half) / half

    @property
    def longest(self) -> float:
        """The step (s) at which that is `MAX_FREQUENCY_ERROR`, at most `LONGEST_STEP`."""
        return min(LONGEST_STEP, sqrt(12 * MAX_FREQUENCY_ERROR) / (2 * pi * self.frequency))


def time_step(structure: Structure, band: float, step: float | None = None) -> TimeStep:
    """Return the step that keeps natural frequencies up to ``band`` (Hz) right to `MAX_FREQUENCY_ERROR`.

    At most `LONGEST_STEP`. With a ``step`` (s) that is given, return what that one does to them.
    """
    given = TimeStep(0.0 if step is None else step, highest_frequency(structure, band))
    return given if step is not None else replace(given, step=given.longest)


def highest_frequency(structure: Structure, band: float) -> float:
    """Return the highest natural frequency (Hz) up to ``band`` (Hz); the lowest of all where none is."""
    linear = linearise(structure)
    available = int(np.count_nonzero(linear.mass.diagonal()))
    count = min(FIRST_MODES, available)
    frequencies = natural_modes(linear, count).frequencies
    while frequencies[-1] <= band and count < available:
        count = min(2 * count, available)
        frequencies = natural_modes(linear, count).frequencies
    within = frequencies[frequencies <= band]
    return float(within[-1] if len(within) else frequencies[0])
