"""In which recordings a cause acts: those that were fitted, and those kept for testing where they show it."""

from collections import Counter

import numpy as np

from hybrid.diagnosis.contest.switching import acting_recordings
from hybrid.diagnosis.fitting.forecast_score import ForecastModel, least_cost
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.outcome.config import MENTION
from hybrid.diagnosis.recorded.batches import Batch, columns_of, count_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel


def recordings_of(
    fit: Fit,
    number: int,
    model: ForecastModel,
    test: tuple[Batch, ...],
    measured: tuple[int, ...],
    noise_model: NoiseModel,
    temper: float,
) -> Counter[str]:
    """Return in how many motions of each recording, by its name, candidate ``number`` of a fit acts.

    What acts in all that were fitted acts in all. Otherwise a test recording's whole motion is held against the
    ``model`` with the candidate and without; nothing but its initial state is fitted. ``temper``: in units of the noise
    of ``noise_model``.
    """
    acting = Counter(acting_recordings(fit, number))
    everywhere = acting.total() == count_of(fit.batches)
    for batch in test:
        with_it = np.ones(len(batch.names), dtype=bool)
        if not everywhere:
            (own,) = columns_of((batch,), measured)
            on, off = (least_cost(model, less, own, noise_model.roles) for less in ((), (number,)))
            with_it = off - on > MENTION.min_acting_fall * temper
        acting.update(name for name, acts in zip(batch.names, with_it, strict=True) if acts)
    return acting
