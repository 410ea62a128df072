"""How strong known loads seem to be, if nothing on the list explains the recordings: all by one factor."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.outcome.changed_dataset import taken_away
from hybrid.diagnosis.outcome.config import MENTION
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel


def loading_of(item: Fit, noise_model: NoiseModel) -> str | None:
    """Return in a sentence which factor on all loads would explain what the model leaves; None where none does.

    ``item``: a fit without any cause. The factor is found for the drawn structure first, then for the best fit with it.
    """
    if not item.hypothesis.is_linear or all(batch.loads is None for batch in item.batches):
        return None
    theta, factor, found = np.zeros_like(item.theta), 1.0, None
    for _ in range(MENTION.load_factor_rounds):
        told = _factor(item, theta, noise_model)
        found = None if told is None else fit(item.hypothesis, theta, _times(item.batches, told), noise_model)
        if told is None or found is None:
            return None
        theta, factor = found.theta, told
    gain = taken_away(found, item)
    if gain is None or abs(factor - 1) < MENTION.min_load_factor_change:
        return None
    return f"all loads times {factor:.4g} {gain}: check their unit, sign and gain"


def _factor(item: Fit, theta: FloatArray, noise_model: NoiseModel) -> float | None:
    """Return the best factor on the loads at ``theta`` (parameter,): the cost is a parabola in it."""
    trials = [
        fit(item.hypothesis, theta, _times(item.batches, by), noise_model, iterations=0) for by in (-1.0, 0.0, 1.0)
    ]
    turned, none, given = (np.nan if trial is None else trial.cost for trial in trials)
    bend = turned + given - 2 * none
    return float((turned - given) / (2 * bend)) if bend > 0 else None


def _times(batches: tuple[Batch, ...], factor: float) -> tuple[Batch, ...]:
    """Return batches with their loads ``factor`` times as large."""
    return tuple(replace(batch, loads=batch.loads and batch.loads.times(factor)) for batch in batches)
