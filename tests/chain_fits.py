"""Fits of blind chains without any cause, and causes to add to them."""

import numpy as np

from fe_models.causes.candidate import Candidate
from fe_models.causes.places import Motion
from fe_models.recordings import Dataset
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.batches import Batch, batches_of, columns_of
from hybrid.diagnosis.recorded.noise import noise_of_recordings, structure_band
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis

MEASURED = (0, 1, 2, 3)
RATE = 10.0
MOTION = Motion(*np.random.default_rng(0).standard_normal((2, 50, 4)))


def candidate(dataset: Dataset, kind: str, **where: object) -> Candidate:
    found = all_candidates(nominal_model_of(dataset), dataset, MOTION, MEASURED)
    return next(c for c in found if c.kind == kind and where.items() <= c.location.items())


def gauge_of(dataset: Dataset) -> tuple[tuple[Batch, ...], NoiseModel]:
    batches = columns_of(batches_of(dataset, "train"), MEASURED)
    sigma = noise_of_recordings(batches, RATE, structure_band(nominal_model_of(dataset), RATE))
    return batches, NoiseModel(tuple(dataset.sensors[i] for i in MEASURED), RATE, sigma)


def nominal_fit(dataset: Dataset, batches: tuple[Batch, ...], noise_model: NoiseModel) -> Fit:
    hypothesis = Hypothesis(nominal_model_of(dataset))
    found = fit(hypothesis, hypothesis.centre, batches, noise_model)
    assert found is not None
    return found
