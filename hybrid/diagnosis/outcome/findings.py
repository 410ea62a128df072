"""Findings: the causes that a diagnosis names, with parameters, uncertainty, rivals and a sentence to act on."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fe_models.effects import Cause, HarmonicForce
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.fitting.fitting import Fit
from hybrid.diagnosis.fitting.wave import wave

VERBS = {
    "stiffness_change": "{place} has {factor} times its nominal stiffness",
    "added_mass": "{place} carries {mass} kg more than the model has (negative: less)",
    "support_spring": "{place} is held by {stiffness} N/m that the model lacks (negative: it has too much)",
    "axial_force": "{place} carries an axial force of {force} N that the model lacks (tension positive)",
    "modal_damping": "{place} is damped with a ratio of {ratio}",
    "point_damper": "a damper of {coefficient} N s/m acts at {place} (negative: the model has too much damping there)",
    "quadratic_damper": "drag of {coefficient} N s^2/m^2 acts at {place}",
    "coulomb_friction": "dry friction of {force} N acts at {place}",
    "cubic_spring": "a cubic spring of {stiffness} N/m^3 acts at {place} (positive: hardening)",
    "gap_stop": "a stop of {stiffness} N/m acts at {place} beyond a gap of {gap} m",
    "slack_cable": "{place} goes slack when its compression exceeds a pretension of {pretension} N",
    "harmonic_force": "a harmonic force of {amplitude} N at {frequency} Hz acts at {place}: look for a machine",
    "sensor_gain": "{place} shows {factor} times the truth: check its calibration and mounting",
    "sensor_delay": "{place} is late by {delay} s (negative: early): check its clock",
    "sensor_drift": "{place} drifts by {slope} units per second",
    "time_integration": "the simulation's own step of {step} s makes the error: choose a smaller one",
}

TINY = 1e-6  # relative: the finite difference between a search's parameter and the reported one


@dataclass(frozen=True)
class Parameter:
    """A value with its standard deviation and SI unit."""

    value: float
    std: float
    unit: str


@dataclass(frozen=True)
class Finding:
    """A ``cause`` with the standard deviations of its parameters, where it acts and what may stand in its place."""

    cause: Cause
    parameters: dict[str, Parameter]
    probability: float
    explains: float
    recordings: tuple[str, ...]
    alternatives: tuple[tuple[str, dict[str, Any], float], ...]
    sentence: str


def cause_of(fit: Fit, number: int, temper: float = 1.0) -> tuple[Cause, dict[str, Parameter]]:
    """Return the cause that candidate ``number`` of a fit amounts to, and its parameters with uncertainty.

    ``temper``: how many values tell as much as one: variances grow by as much.
    """
    candidate, part = fit.hypothesis.candidates[number], fit.hypothesis.slices[number]
    values = [float(value) for value in fit.theta[part]]
    errors = np.sqrt(temper * np.diag(fit.covariance)[part])
    cause = candidate.build(*values)
    deviations = {}
    for i, (word, error) in enumerate(zip(candidate.names, errors, strict=True)):
        moved = candidate.build(*(value * (1 + TINY * (i == k)) for k, value in enumerate(values)))
        if word not in cause.parameters:  # what only helps the search
            continue
        change = float(np.subtract(moved.parameters[word], cause.parameters[word]))
        slope = change / (TINY * values[i]) if values[i] else 1.0
        deviations[word] = abs(slope) * error  # the search may use another measure than the report
    if isinstance(cause, HarmonicForce):
        found_wave = wave(fit, number)
        cause = replace(cause, amplitude=found_wave.amplitude, phase=found_wave.phase)
        deviations |= {"amplitude": found_wave.error, "phase": np.pi}  # the phase is each recording's own
    units = cause.units
    found = {
        word: Parameter(float(value), float(deviations.get(word, 0.0)), units[word])
        for word, value in cause.parameters.items()
        if not isinstance(value, list)
    }
    return cause, found


def place_words(location: dict[str, Any]) -> str:
    """Return a location in words."""
    if "sensor" in location:
        return f"sensor {location['sensor']}"
    if "element" in location:
        return f"element {location['element']}"
    if len(location.get("elements", ())) == 1:
        return f"element {location['elements'][0]}"
    if "elements" in location:
        return f"each of elements {location['elements'][0]} to {location['elements'][-1]}"
    if "modes" in location:
        return "mode " + ", ".join(str(mode) for mode in location["modes"])
    if "nodes" in location:
        return f"nodes {location['nodes'][0]} and {location['nodes'][1]} in {location['direction']}"
    if "direction" in location:
        return f"node {location['node']} in {location['direction']}"
    return f"node {location['node']}" if "node" in location else "the whole model"


def sentence_of(cause: Cause, parameters: dict[str, Parameter]) -> str:
    """Return one sentence that an engineer can act on."""
    numbers = {word: _number(item) for word, item in parameters.items()}
    text = VERBS[cause.kind].format(place=place_words(cause.location), **numbers)
    return text[0].upper() + text[1:] + "."


def _number(item: Parameter) -> str:
    return f"{item.value:.4g} +- {item.std:.2g}" if item.std > 0 else f"{item.value:.4g}"


def reported_location(candidate: Candidate) -> dict[str, Any]:
    """Return a candidate's location in the words of a report: the side of a stop is a parameter there."""
    return {name: value for name, value in candidate.location.items() if name != "side"}
