"""Findings: the causes that a diagnosis names, with parameters, uncertainty, rivals and a sentence to act on."""

from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

import numpy as np

from fe_models.causes import Cause, GapStop, HarmonicForce, SupportSpring
from fe_models.structure import Support
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.fitting.harmonic_amplitude import harmonic_amplitude
from hybrid.diagnosis.fitting.least_squares import Fit

VERBS = {
    "stiffness_change": "{place} has {factor} times its nominal stiffness",
    "added_mass": "{place} carries {mass} more than the model has (negative: less)",
    "support_spring": "{place} is held by {stiffness} that the model lacks (negative: it has too much)",
    "axial_force": "{place} carries an axial force of {force} that the model lacks (tension positive)",
    "dead_load": "the structure feels its own weight and prestress (P-delta), {share} times what is drawn; the model's"
    " natural modes leave them out",
    "modal_damping": "{place} is damped with a ratio of {ratio}",
    "point_damper": "a damper of {coefficient} acts {at} (negative: the model has too much damping there)",
    "quadratic_damper": "drag of {coefficient} acts {at}",
    "coulomb_friction": "dry friction of {force} acts {at}",
    "cubic_spring": "a cubic spring of {stiffness} acts {at} (positive: hardening)",
    "gap_stop": "a stop of {stiffness} acts {at} beyond a gap of {gap} that closes as {closing}",
    "slack_cable": "{place} goes slack when its compression exceeds a pretension of {pretension}",
    "harmonic_force": "a harmonic force of {amplitude} at {frequency} acts {at}: look for a machine",
    "sensor_gain": "{place} shows {factor} times the truth: check its unit, calibration and mounting",
    "sensor_delay": "{place} is late by {delay} (negative: early): check its clock",
    "sensor_drift": "{place} drifts by {slope}",
    "time_integration": "the simulation's own step of {step} makes the error: choose a smaller one",
}
TOO_SOFT = "{place} is held by {stiffness} only, where the model holds it rigidly"  # a spring in a support's place
UNITS = {"1": "", "unit/s": " of its units a second"}  # in words, where the symbol does not say it

OF_EACH = ("phase",)  # parameters of which each recording has its own
NOT_ON_THE_LIST = "not_on_the_list"  # what is said in a cause's place where it may be something that no kind describes,
OTHER_CAUSES = "other_causes"  # and where it is a cause too improbable to be listed by itself, or several at once

NUDGE = 1e-6  # relative: the finite difference between a search's parameter and the reported one


@dataclass(frozen=True)
class Parameter:
    """A value with its standard deviation and SI unit."""

    value: float
    std: float
    unit: str


@dataclass(frozen=True)
class Alternative:
    """What may stand in a finding's place: its ``kind`` and ``location``, and its ``probability``.

    With those of all alternatives a finding's probability adds up to one: the remainder is `OTHER_CAUSES` and
    `NOT_ON_THE_LIST`, which are nowhere.
    """

    kind: str
    location: dict[str, Any]
    probability: float

    @property
    def is_remainder(self) -> bool:
        """Whether it stands for all that is not listed by itself."""
        return self.kind in (NOT_ON_THE_LIST, OTHER_CAUSES)


@dataclass(frozen=True, repr=False)
class Finding:
    """A ``cause`` and its ``parameters`` with standard deviations, and the ``probability`` that it is right.

    ``explains``: share of what the nominal model gets wrong, in energy, that it takes away; ``recordings`` where it
    acts: the name of one for each of its motions; ``alternatives`` that the sensors cannot rule out; ``sentence``: what
    an engineer can act on.
    """

    cause: Cause
    parameters: dict[str, Parameter]
    probability: float
    explains: float
    recordings: tuple[str, ...]
    alternatives: tuple[Alternative, ...]
    sentence: str

    def __repr__(self) -> str:
        return f"Finding({self.cause.kind} {at_place(self.cause.location)}, probability {self.probability:.2f})"


def cause_of(fit: Fit, number: int, widened: float) -> tuple[Cause, dict[str, Parameter]]:
    """Return the cause that candidate ``number`` of a fit amounts to, and its parameters with uncertainty.

    ``widened``: what variances grow by, as of a `Posterior`.
    """
    candidate, part = fit.hypothesis.candidates[number], fit.hypothesis.slices[number]
    values = [float(value) for value in fit.theta[part]]
    errors = np.sqrt(widened * np.diag(fit.covariance)[part])
    cause = candidate.build(*values)
    deviations = {}
    for i, (word, error) in enumerate(zip(candidate.names, errors, strict=True)):
        moved = candidate.build(*(value * (1 + NUDGE * (i == k)) for k, value in enumerate(values)))
        if word not in cause.parameters:  # what only helps the search
            continue
        change = float(np.subtract(moved.parameters[word], cause.parameters[word]))
        slope = change / (NUDGE * values[i]) if values[i] else 1.0
        deviations[word] = abs(slope) * error  # the search may use another measure than the report
    if isinstance(cause, HarmonicForce):
        found_wave = harmonic_amplitude(fit, number)
        cause = replace(cause, amplitude=found_wave.amplitude, phase=found_wave.phase)
        deviations["amplitude"] = found_wave.error * np.sqrt(widened)
    units = cause.units
    found = {
        word: Parameter(float(value), float(deviations.get(word, 0.0)), units[word])
        for word, value in cause.parameters.items()
        if not isinstance(value, list) and word not in OF_EACH
    }
    return cause, found


def place_words(location: dict[str, Any]) -> str:
    """Return a location in words."""
    if "sensor" in location:
        return f"sensor {location['sensor']}"
    if "element" in location:
        return f"element {location['element']}"
    if "elements" in location:
        one = len(location["elements"]) == 1
        return f"element {location['elements'][0]}" if one else f"each of elements {_runs(location['elements'])}"
    if "modes" in location:
        return "mode " + ", ".join(str(mode) for mode in location["modes"])
    if "nodes" in location:
        return f"nodes {location['nodes'][0]} and {location['nodes'][1]} in {location['direction']}"
    if "direction" in location:
        return f"node {location['node']} in {location['direction']}"
    return f"node {location['node']}" if "node" in location else "the whole model"


def _runs(numbers: list[int]) -> str:
    """Return numbers in words, those that follow one another as "1 to 4"."""
    groups = groupby(enumerate(sorted(numbers)), key=lambda item: item[1] - item[0])  # constant along a run
    runs = [[number for _, number in group] for _, group in groups]
    words = [f"{run[0]} to {run[-1]}" if len(run) > 1 else str(run[0]) for run in runs]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def at_place(location: dict[str, Any]) -> str:
    """Return where something acts, in words: at a place, between two nodes, in the whole model."""
    preposition = "between" if "nodes" in location else "at" if location else "in"
    return f"{preposition} {place_words(location)}"


def is_held(supports: tuple[Support, ...], cause: Cause) -> bool:
    """Return whether a cause is a spring that takes the place of one of the nominal ``supports``."""
    return isinstance(cause, SupportSpring) and any(
        support.node == cause.node and cause.direction in support.directions for support in supports
    )


def sentence_of(cause: Cause, parameters: dict[str, Parameter], *, held: bool) -> str:
    """Return one sentence that an engineer can act on; ``held``: the nominal model has a support there."""
    numbers = {word: _number(item) for word, item in parameters.items()}
    where = {"place": place_words(cause.location), "at": at_place(cause.location)}
    if isinstance(cause, GapStop):
        where["closing"] = _closing(cause)
    text = (TOO_SOFT if held else VERBS[cause.kind]).format(**where, **numbers)
    return text[0].upper() + text[1:] + "."


def _number(item: Parameter) -> str:
    error = f" +- {item.std:.2g}" if item.std > 0 else ""
    return f"{item.value:.4g}{error}{UNITS.get(item.unit, f' {item.unit}')}"


def _closing(stop: GapStop) -> str:
    """Return which motion meets a stop."""
    against = "" if len(stop.nodes) == 1 else f" against node {stop.nodes[0]}"
    return f"node {stop.nodes[-1]} moves in {'+' if stop.side > 0 else '-'}{stop.direction}{against}"


def reported_location(candidate: Candidate) -> dict[str, Any]:
    """Return a candidate's location in the words of a report: the side of a stop is a parameter there."""
    return {name: value for name, value in candidate.location.items() if name != "side"}
