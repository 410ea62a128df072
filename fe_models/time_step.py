"""The time step that a simulation needs, from the highest natural frequency that its recordings hold.

The trapezoidal rule (Newmark, constant average acceleration) replaces a circular frequency w by
2 arctan(w h / 2) / h: too low by a share of (w h)^2 / 12, for a step h, whatever the damping. To whoever compares
recordings with a model, a step too long is a structure too soft. Hughes, The Finite Element Method, 1987, section 9.3.
"""

from dataclasses import dataclass, replace
from math import atan, pi, sqrt
from typing import Literal

from fe_models.assembly import linearise
from fe_models.linear import LinearModel, ModalModel
from fe_models.mode_count import mode_count
from fe_models.modes import natural_modes
from fe_models.structure import Structure

MAX_FREQUENCY_ERROR = 1e-4
"""Of the highest mode in the band, relative. In a portal recorded for 12 s with 2 % noise a diagnosis sees steps that
make 26e-4 (1 ms, 28 Hz) and takes part of them for a mass; at 1e-4 and 0.3e-4 it says that nothing is wrong."""
LONGEST_STEP = 1e-3
"""s. Stops, friction and cables that go slack need short steps whatever the modes."""
Integrator = Literal["rk67", "newmark"]
"""Of free motion: explicit, of order 6, or the trapezoidal rule."""
MAX_PHASE_PER_STEP: dict[Integrator, float] = {"rk67": 0.15, "newmark": sqrt(12 * MAX_FREQUENCY_ERROR)}
"""omega times step of the highest mode: the one of order 6 is then off by 4e-6 after a hundred periods."""
LONGEST_FREE_STEP = 0.05
"""s. Leaves 1e-7 in the chain of `four_dof`, and a cubic spring as stiff as its linear ones is followed, too."""
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


def free_step(model: LinearModel, integrator: Integrator = "rk67") -> float:
    """Return the step (s) in which an ``integrator`` follows all modes of a model, at most `LONGEST_FREE_STEP`."""
    return min(LONGEST_FREE_STEP, MAX_PHASE_PER_STEP[integrator] / float(all_modes(model).omega[-1]))


def sampling_faults(model: LinearModel, sampling_rate: float) -> list[str]:
    """Return a fault where free motion has frequencies that recordings would show folded down.

    Those above half the ``sampling_rate`` (Hz), as every mode takes part in it.
    """
    highest = float(all_modes(model).frequencies[-1])
    if highest <= sampling_rate / 2:
        return []
    return [
        f"natural frequencies go up to {highest:.4g} Hz, above half the sampling_rate of {sampling_rate:g} Hz:"
        f" sample at {2.5 * highest:.3g} Hz or more"
    ]


def all_modes(model: LinearModel) -> ModalModel:
    """Return all natural modes of a model, as many as degrees of freedom have mass."""
    return natural_modes(model, mode_count(model))


def highest_frequency(structure: Structure, band: float) -> float:
    """Return the highest natural frequency (Hz) up to ``band`` (Hz); the lowest of all where none is."""
    linear = linearise(structure)
    available = mode_count(linear)
    count = min(FIRST_MODES, available)
    frequencies = natural_modes(linear, count).frequencies
    while frequencies[-1] <= band and count < available:
        count = min(2 * count, available)
        frequencies = natural_modes(linear, count).frequencies
    within = frequencies[frequencies <= band]
    return float(within[-1] if len(within) else frequencies[0])
