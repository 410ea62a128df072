"""How strong known loads seem to be, if nothing on the list explains the recordings: all by one factor."""

from dataclasses import replace

import numpy as np

from hybrid.diagnosis.fitting.fitting import Fit, fit
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.recorded.records import Batch

LEAVES = 0.1  # of what the model leaves beyond noise: the most that loads so changed may leave
ROUNDS = 3  # of the factor and the nominal values in turn
TOLD = 0.02  # a factor nearer to one is none


def loading_of(item: Fit, gauge: Gauge) -> str | None:
    """Return in a sentence which factor on all loads would explain what the model leaves; None where none does.

    ``item``: a fit without any cause. The factor is found for the drawn structure first, then for the best fit with it.
    """
    if not item.hypothesis.is_linear or all(batch.loads is None for batch in item.batches):
        return None
    best, factor = replace(item, theta=np.zeros_like(item.theta)), 1.0
    for _ in range(ROUNDS):
        told = _factor(best, item, gauge)
        found = None if told is None else fit(item.hypothesis, best.theta, _times(item.batches, told), gauge)
        if told is None or found is None:
            return None
        best, factor = found, told
    if abs(factor - 1) < TOLD or best.misfit > LEAVES * item.misfit:
        return None
    share = 1 - max(best.misfit, 0.0) / item.misfit
    return (
        f"all loads times {factor:.4g} would take {share:.0%} of what the model leaves beyond noise away: check their"
        " unit, sign and gain"
    )


def _factor(near: Fit, item: Fit, gauge: Gauge) -> float | None:
    """Return the best factor on the loads for the parameters of a fit: its cost is a parabola in it."""
    trials = [
        fit(item.hypothesis, near.theta, _times(item.batches, factor), gauge, iterations=0)
        for factor in (-1.0, 0.0, 1.0)
    ]
    turned, none, given = (np.nan if trial is None else trial.cost for trial in trials)
    bend = turned + given - 2 * none
    return float((turned - given) / (2 * bend)) if bend > 0 else None


def _times(batches: tuple[Batch, ...], factor: float) -> tuple[Batch, ...]:
    """Return batches with their loads ``factor`` times as large."""
    return tuple(
        batch
        if batch.loads is None
        else replace(batch, loads=replace(batch.loads, courses=factor * batch.loads.courses))
        for batch in batches
    )
