"""Test recordings that are noisier than those for training, and otherwise as the model says."""

from dataclasses import replace

import numpy as np

from hybrid.diagnosis.fitting.fitting import Fit
from hybrid.diagnosis.fitting.forecasting import begun_from
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.outcome.verdict import NEAR
from hybrid.diagnosis.recorded.noise import noise_of_recordings
from hybrid.diagnosis.recorded.records import columns_of
from hybrid.diagnosis.response.unloaded import unloaded


def only_noisier(scorer: Scorer, item: Fit) -> tuple[str, ...]:
    """Return the names of test recordings that a fit follows, from the initial states that they ask for whole, as well
    as their own noise lets it, where that is more than is usual; of several motions in one file, if all are so.
    """
    if any(batch.off for batch in item.batches):
        return ()
    gauge, rate = scorer.gauge, scorer.setting.dataset.sampling_rate
    followed, noisier = dict[str, bool](), dict[str, bool]()
    for batch in columns_of(scorer.test, scorer.setting.measured):
        begun = begun_from(scorer.model(item), (), batch, gauge.sensors, gauge.positions, gauge, batch.samples)
        usual = np.broadcast_to(batch.sigma(gauge)[:, 0], (len(batch.names), len(gauge.sensors)))
        (free,) = unloaded(scorer.setting.plant, (replace(batch, noise=None),), gauge.sensors, rate)
        for number, name in enumerate(batch.names):
            own = noise_of_recordings((free.take([number]),), rate, scorer.setting.band)
            louder = float(np.mean((own / usual[number]) ** 2))
            expected = louder * batch.samples * batch.share * len(own)
            followed[name] = followed.get(name, True) and bool(begun.cost[number] <= NEAR**2 * expected)
            noisier[name] = noisier.get(name, False) or louder > NEAR**2
    return tuple(name for name in followed if followed[name] and noisier[name])
