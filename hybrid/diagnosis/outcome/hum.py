"""Tones that one sensor picks up, as electrical hum is: on no list, but they look like a machine next to the sensor.

A machine shakes the structure, and other sensors show that, be it little; a tone of the sensor's own they do not.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import HarmonicCandidate
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.outcome.config import MENTION, VERDICT
from hybrid.diagnosis.outcome.rest import rests
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.spectra import clearest_line
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import modal_form

AS_WELL = (
    "of all sensors {sensor} alone shows the harmonic force at {frequency:.4g} Hz: a tone that this sensor picks up, as"
    " electrical hum, would look the same"
)
RATHER = (
    "a tone at {frequency:.4g} Hz that sensor {sensor} alone picks up, as electrical hum, would explain the recordings"
    " better than a machine does, which other sensors would show: check its cable and supply, or leave it out"
)
LINE = (
    "sensor {sensor} has a line at {frequency:.4g} Hz that counts as noise, as nothing of the structure is there:"
    " electrical hum, or a machine that it hardly feels"
)


@dataclass(frozen=True)
class Hum:
    """A tone of ``frequency`` (Hz) of one ``sensor`` in the place of a fit's harmonic force, ``number`` among its
    causes; ``machine``: probability that it is the force all the same.
    """

    number: int
    sensor: str
    frequency: float
    machine: float

    @property
    def is_likely(self) -> bool:
        """Whether it is hum rather than a machine."""
        return self.machine < MENTION.max_no_machine_probability

    @property
    def sentence(self) -> str | None:
        """What a user should know of it, None where it is no hum."""
        if self.machine > MENTION.min_machine_probability:
            return None
        return (RATHER if self.is_likely else AS_WELL).format(sensor=self.sensor, frequency=self.frequency)


def hums_of(item: Fit, noise_model: NoiseModel, temper: float) -> tuple[Hum, ...]:
    """Return what may stand in the place of each harmonic force of a fit: a tone of the sensor that shows it most.

    By what the sum of squares would rise if no other sensor showed the force, over the ``temper``; a force is on the
    list, and as much likelier beforehand. Beside a force law nothing is said: what a machine does is not alone there.
    """
    causes = item.hypothesis.candidates
    if not item.hypothesis.is_linear:
        return ()
    found = (
        _hum(item, number, noise_model, temper)
        for number, cause in enumerate(causes)
        if isinstance(cause, HarmonicCandidate)
    )
    return tuple(hum for hum in found if hum is not None)


def verdict_with(hums: tuple[Hum, ...], causes: int, verdict: Verdict) -> Verdict:
    """Return a ``verdict`` on as many ``causes`` where some of them are likely to be hum, which is none on the list."""
    likely = sum(hum.is_likely for hum in hums)
    if not likely or verdict not in (Verdict.EXPLAINED, Verdict.PARTLY_EXPLAINED):
        return verdict
    return Verdict.UNEXPLAINED if likely == causes else Verdict.PARTLY_EXPLAINED


def line_of(item: Fit, noise_model: NoiseModel) -> str | None:
    """Return a note on the clearest line of what a fit leaves, None where noise makes all of them."""
    found = clearest_line(rests(item, noise_model), noise_model.rate, item.hypothesis.nominal.cutoff)
    return None if found is None else LINE.format(sensor=noise_model.sensors[found[0]].name, frequency=found[1])


def _hum(item: Fit, number: int, noise_model: NoiseModel, temper: float) -> Hum | None:
    """Return what may stand in the place of harmonic force ``number``, None at a resonance, which all sensors show."""
    frequency = float(item.theta[item.hypothesis.slices[number].start])
    rise = np.zeros(len(noise_model.sensors))
    for batch, states, residual in zip(item.batches, item.states, item.residuals, strict=True):
        if number not in batch.off:
            hypothesis, kept = item.hypothesis.less(batch.off), item.hypothesis.parameters_of(batch.off)
            shown = _steady(hypothesis, item.theta[kept], frequency, states, batch.samples, noise_model)
            if shown is None:
                return None
            shown /= batch.sigma(noise_model)
            rise += np.sum(shown * (2 * residual + shown), axis=(0, 1))
    loudest = int(np.argmax(rise))
    log_odds = float(rise.sum() - rise[loudest]) / (2 * temper)
    machine = float(expit(np.log(VERDICT.listed / (1 - VERDICT.listed)) + log_odds))
    return Hum(number, noise_model.sensors[loudest].name, frequency, machine)


def _steady(
    hypothesis: Hypothesis,
    theta: FloatArray,
    frequency: float,
    states: FloatArray,
    samples: int,
    noise_model: NoiseModel,
) -> FloatArray | None:
    """Return what sensors show of the steady motion at a ``frequency`` (Hz), (recording, time, sensor): of the undamped
    root there. None at a resonance.
    """
    system = system_of(hypothesis, theta[None], noise_model.outputs)
    form = modal_form(system)
    if form is None:
        return None
    at = int(np.argmin(np.abs(form.roots[0] - 2j * np.pi * frequency)))
    time = np.arange(samples) / noise_model.rate
    wave = np.exp(form.roots[0, at] * time)
    return np.asarray(np.real((states @ form.left[0, at])[:, None, None] * wave[:, None] * form.right[0, :, at]))
