"""In which recordings a cause acts: those that were fitted, and those kept for testing where they tell."""

from collections import Counter

import numpy as np

from hybrid.diagnosis.contest.switching import acting_recordings
from hybrid.diagnosis.fitting.fitting import Fit
from hybrid.diagnosis.fitting.forecasting import Model, least_cost
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.recorded.records import Batch, columns_of, count_of

TOLD = 12.0  # in the tempered sum of squares: by how much a test recording must do better with the cause than without


def recordings_of(
    fit: Fit, number: int, model: Model, test: tuple[Batch, ...], measured: tuple[int, ...], gauge: Gauge, temper: float
) -> Counter[str]:
    """Return in how many motions of each recording, by its name, candidate ``number`` of a fit acts.

    What acts in all that were fitted acts in all. Otherwise a test recording's whole motion is held against the
    ``model`` with the candidate and without; nothing but its initial state is fitted. ``temper``: in units of the noise
    of ``gauge``.
    """
    acting = Counter(acting_recordings(fit, number))
    everywhere = acting.total() == count_of(fit.batches)
    for batch in test:
        with_it = np.ones(len(batch.names), dtype=bool)
        if not everywhere:
            (own,) = columns_of((batch,), measured)
            on, off = (least_cost(model, less, own, gauge.view) for less in ((), (number,)))
            with_it = off - on > TOLD * temper
        acting.update(name for name, acts in zip(batch.names, with_it, strict=True) if acts)
    return acting
