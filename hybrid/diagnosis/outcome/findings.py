"""Findings: the causes that a diagnosis names, with parameters, uncertainty, rivals and a sentence to act on."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import Cause, HarmonicForce
from fe_models.causes.candidate import Candidate
from fe_models.causes.wording import at_place
from fe_models.structure import Structure
from hybrid.diagnosis.fitting.harmonic_amplitude import harmonic_amplitude
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.outcome.config import SHARE
from hybrid.diagnosis.probability import two_decimals

UNITS = {"1": "", "unit/s": " of its units a second"}  # in words, where the symbol does not say it

OF_EACH = ("phase",)  # parameters of which each recording has its own
NOT_ON_THE_LIST = "not_on_the_list"  # what is said in a cause's place where it may be something that no kind describes,
OTHER_CAUSES = "other_causes"  # and where it is a cause too improbable to be listed by itself, or several at once


@dataclass(frozen=True)
class Parameter:
    """A value with its standard deviation and SI unit."""

    value: float
    std: float
    unit: str


@dataclass(frozen=True)
class Alternative:
    """What may stand in a finding's place: its ``kind`` and ``location``, and its ``probability``.

    ``parameters``: its size, where it was fitted there; empty elsewhere. With those of all alternatives a finding's
    probability adds up to one: the remainder is `OTHER_CAUSES` and `NOT_ON_THE_LIST`, which are nowhere.
    """

    kind: str
    location: dict[str, Any]
    probability: float
    parameters: dict[str, Parameter] = field(default_factory=dict)

    @property
    def is_remainder(self) -> bool:
        """Whether it stands for all that is not listed by itself."""
        return self.kind in (NOT_ON_THE_LIST, OTHER_CAUSES)


@dataclass(frozen=True, repr=False)
class Finding:
    """A ``cause`` and its ``parameters`` with standard deviations, and the ``probability`` that it is right.

    ``explains``: share of what the nominal model gets wrong, in energy, that it takes away; ``recordings`` where it
    acts: the name of one for each of its motions; ``alternatives`` that the sensors cannot rule out; ``sentence``: what
    an engineer can act on. ``gain``: of what acts in some recordings only, the share of what forecasts of these get
    wrong beyond noise that it takes away; None where none were made.
    """

    cause: Cause
    parameters: dict[str, Parameter]
    probability: float
    explains: float
    recordings: tuple[str, ...]
    alternatives: tuple[Alternative, ...]
    sentence: str
    gain: float | None = None

    @property
    def probability_of_kind(self) -> float:
        """The probability that it is a cause of this kind, at whatever place."""
        return self.probability + sum(item.probability for item in self.alternatives if item.kind == self.cause.kind)

    def __repr__(self) -> str:
        what = f"{self.cause.kind} {at_place(self.cause.location)}"
        return f"Finding({what}, probability {two_decimals(self.probability)})"


def cause_of(fit: Fit, number: int, widened: float) -> tuple[Cause, dict[str, Parameter]]:
    """Return the cause that candidate ``number`` of a fit amounts to, and its parameters with uncertainty.

    ``widened``: what variances grow by, as of a `Posterior`.
    """
    candidate, part = fit.hypothesis.candidates[number], fit.hypothesis.slices[number]
    cause, deviations = built(candidate, fit.theta[part], np.sqrt(widened * np.diag(fit.covariance)[part]))
    if isinstance(cause, HarmonicForce):
        found_wave = harmonic_amplitude(fit, number)
        cause = replace(cause, amplitude=found_wave.amplitude, phase=found_wave.phase)
        deviations["amplitude"] = found_wave.error * np.sqrt(widened)
    return cause, parameters_of(cause, deviations)


def built(candidate: Candidate, values: FloatArray, errors: FloatArray) -> tuple[Cause, dict[str, float]]:
    """Return the cause of a candidate's ``values`` (parameter,), and the standard deviation of each reported parameter.

    ``errors`` (parameter,) of the values: the search may use another measure than the report.
    """
    numbers = [float(value) for value in values]
    cause, deviations = candidate.build(*numbers), dict[str, float]()
    for i, (word, error) in enumerate(zip(candidate.names, errors, strict=True)):
        if word not in cause.parameters:  # what only helps the search
            continue
        moved = candidate.build(*(value * (1 + SHARE.difference_step * (i == k)) for k, value in enumerate(numbers)))
        change = float(np.subtract(moved.parameters[word], cause.parameters[word]))
        slope = change / (SHARE.difference_step * numbers[i]) if numbers[i] else 1.0
        deviations[word] = abs(slope) * float(error)
    return cause, deviations


def parameters_of(cause: Cause, deviations: Mapping[str, float]) -> dict[str, Parameter]:
    """Return what is reported of a cause's parameters, with their standard ``deviations``."""
    return {
        word: Parameter(float(value), float(deviations.get(word, 0.0)), cause.units[word])
        for word, value in cause.parameters.items()
        if not isinstance(value, list) and word not in OF_EACH
    }


def sentence_of(cause: Cause, parameters: dict[str, Parameter], structure: Structure) -> str:
    """Return one sentence that an engineer can act on; ``structure``: the nominal one."""
    return cause.sentence({word: in_words(item) for word, item in parameters.items()}, structure)


def in_words(item: Parameter) -> str:
    """Return a value with its standard deviation and unit."""
    error = f" +- {item.std:.2g}" if item.std > 0 else ""
    return f"{item.value:.4g}{error}{UNITS.get(item.unit, f' {item.unit}')}"
