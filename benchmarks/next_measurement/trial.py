"""One case: all causes compared, and where that leaves it open, once more as advised, and with a random addition.

Compared are all single causes with a linear effect that are drawn, at all places, each fitted to every sample: what the
search of a diagnosis comes to at its end, without its short cuts, force laws and second causes, in a second or two.
"""

import time
from dataclasses import dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.blind.judging import CONFIDENT_PROBABILITY, key_of
from benchmarks.next_measurement.cases import CONFIG, KINDS, OpenCase
from fe_models.arrays import FloatArray
from fe_models.causes.places import Motion
from fe_models.recordings import Dataset
from hybrid.diagnosis.config import THREADS
from hybrid.diagnosis.contest.posterior import Posterior, of_candidate, posterior_of, twins_of
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.next_measurement.by_series import next_by_series
from hybrid.diagnosis.next_measurement.in_excitations import considered
from hybrid.diagnosis.next_measurement.measurements import Measurement, moving_places, possible_sensors
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.batches import batches_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis


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
    truth = key_of(case.cause)
    with threadpool_limits(THREADS.linear_algebra, "blas"):
        dataset = case.dataset()
        known, noise_model = compared(dataset)
        then = next_by_series(known, noise_model, dataset.sensors)
        own = _probability_of(truth, known)
        promised, advised, other = None, None, None
        if then is not None and then.options and 0 < own < CONFIDENT_PROBABILITY:
            nominal = nominal_model_of(dataset)
            every = [Measurement.by(sensor) for sensor in possible_sensors(nominal, dataset.sensors)]
            every += considered(moving_places(nominal))
            best, drawn = then.options[0], every[int(np.random.default_rng(seed).integers(len(every)))]
            promised, advised = best.probability, _added(case, best.measurement)
            other = advised if drawn == best.measurement else _added(case, drawn)
    names = tuple(sensor.name for sensor in case.sensors)
    took = time.process_time() - begun
    return Trial(seed, truth, names, own, then is not None, promised, advised, other, took)


def compared(dataset: Dataset) -> tuple[Posterior, NoiseModel]:
    """Return the posterior of all single causes, and of none, as the search by time series has it, and the noise."""
    nominal, batches = nominal_model_of(dataset), batches_of(dataset, "train")
    columns = tuple(range(len(dataset.sensors)))
    sigma = CONFIG.noise * batches[0].data.std(axis=(0, 1))
    noise_model = NoiseModel(dataset.sensors, dataset.sampling_rate, sigma)
    usual = Motion(*np.random.default_rng(0).standard_normal((2, 50, len(nominal.dofs))))  # it sizes force laws alone
    every = all_candidates(nominal, dataset, usual, columns)
    candidates = tuple(candidate for candidate in every if candidate.kind in KINDS)
    base = Hypothesis(nominal)
    hypotheses = (base, *(base.adding(candidate) for candidate in candidates))
    fits = [fit(hypothesis, _start(hypothesis), batches, noise_model) for hypothesis in hypotheses]
    return posterior_of(tuple(item for item in fits if item is not None), candidates), noise_model


def _start(hypothesis: Hypothesis) -> FloatArray:
    """Return theta (parameter,) where the fit of a hypothesis begins."""
    theta = hypothesis.centre
    for candidate, part in zip(hypothesis.candidates, hypothesis.slices, strict=True):
        theta[part] = candidate.first_starts[0]
    return theta


def _added(case: OpenCase, measurement: Measurement) -> Added:
    known, truth = compared(case.dataset(measurement))[0], key_of(case.cause)
    first = [candidate.key for candidate in known.fits[0].hypothesis.candidates] == [truth]
    return Added(measurement.title, _probability_of(truth, known), first)


def _probability_of(truth: str, known: Posterior) -> float:
    """Return the probability of the hidden cause, shared with the places at which it would do the same."""
    for item in known.fits:
        for candidate in item.hypothesis.candidates:
            if truth in {candidate.key, *(twin.key for twin in twins_of(candidate))}:
                return of_candidate(known, candidate)
    return 0.0
