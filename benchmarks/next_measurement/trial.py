"""One case: diagnosed, and where that leaves it open, once more with what the advice says, and with a random addition.

Only then is the truth opened: the advice is asked for whatever the answer is worth.
"""

import time
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.blind.judging import CONFIDENT_PROBABILITY, key_of
from benchmarks.next_measurement.cases import OpenCase
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.config import THREADS
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.next_measurement.in_excitations import considered
from hybrid.diagnosis.next_measurement.measurements import Measurement, moving_places, possible_sensors
from hybrid.diagnosis.nominal.nominal_model import nominal_model_of


@dataclass(frozen=True)
class Added:
    """A ``measurement`` that was added, the ``probability`` of the truth then, and whether it is named ``first``."""

    measurement: str
    probability: float
    first: bool

    @property
    def resolves(self) -> bool:
        """Whether the truth is named first, at 0.9 or more."""
        return self.first and self.probability >= CONFIDENT_PROBABILITY


@dataclass(frozen=True)
class Trial:
    """What became of the case of a ``seed``: its hidden ``truth``, the ``probability`` of it by the ``sensors``.

    ``advised``, with the probability of the right cause that was ``promised``, and ``random``: None where the case is
    not open, or no measurement was said to be of use. ``seconds`` of the processor.
    """

    seed: int
    truth: str
    sensors: tuple[str, ...]
    probability: float
    has_rivals: bool
    promised: float | None
    advised: Added | None
    random: Added | None
    seconds: float

    @property
    def is_open(self) -> bool:
        """Whether the truth is among several causes of which none is sure."""
        return self.has_rivals and 0 < self.probability < CONFIDENT_PROBABILITY


def tried(seed: int) -> Trial:
    """Return the trial of a seed's case."""
    begun, case = time.process_time(), OpenCase.of(seed)
    with threadpool_limits(THREADS.linear_algebra, "blas"):
        dataset = case.dataset()
        found = diagnose(dataset)
        then, truth = found.next_measurement, key_of(case.cause)
        probability = _probability_of(truth, found)
        is_open = then is not None and 0 < probability < CONFIDENT_PROBABILITY
        promised, advised, other = None, None, None
        if then is not None and then.options and is_open:
            nominal = nominal_model_of(dataset)
            sensors = possible_sensors(nominal, dataset.sensors)
            every = [Measurement.by(sensor) for sensor in sensors]
            every += considered(moving_places(nominal))
            best, drawn = then.options[0], every[int(np.random.default_rng(seed).integers(len(every)))]
            promised, advised = best.probability, _added(case, best.measurement)
            other = advised if drawn == best.measurement else _added(case, drawn)
    names = tuple(sensor.name for sensor in case.sensors)
    took = time.process_time() - begun
    return Trial(seed, truth, names, probability, then is not None, promised, advised, other, took)


def _added(case: OpenCase, measurement: Measurement) -> Added:
    found, truth = diagnose(case.dataset(measurement)), key_of(case.cause)
    first = bool(found.findings) and key_of(found.findings[0].cause) == truth
    return Added(measurement.title, _probability_of(truth, found), first)


def _probability_of(truth: str, found: Answer) -> float:
    """Return the probability that an answer gives to the hidden cause, 0 where it does not list it."""
    for finding in found.findings:
        if key_of(finding.cause) == truth:
            return finding.probability
        for item in finding.alternatives:
            if f"{item.kind} {item.location}" == truth:
                return item.probability
    return 0.0
