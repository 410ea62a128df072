"""Test recordings that are noisier than those for training, and otherwise as the model says."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import BoolArray, FloatArray
from hybrid.diagnosis.fitting.forecast_score import least_cost
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.recorded.batches import Batch, columns_of
from hybrid.diagnosis.recorded.noise import noise_of_recordings
from hybrid.diagnosis.response.load_removal import without_load_response

NOISIER = "test recordings ({names}) are noisier than those for training: they are scored against their own noise"


def with_own_noise(scorer: Scorer, item: Fit) -> tuple[Scorer, list[str]]:
    """Return a scorer that knows the noise of test recordings that are only noisier, and a note on these.

    Only noisier is what a fit follows, from the initial states that it asks for whole, as well as its own noise lets
    it, where that is more than is usual. Asked only where the fit forecasts some recording wrongly.
    """
    if any(batch.off for batch in item.batches) or not scorer.wrong_in(scorer.forecast(item)):
        return scorer, []
    batches, names = list[Batch](), dict[str, None]()
    for batch in scorer.test:
        own, noisier = _only_noisier(scorer, item, batch)
        known = np.ones((len(batch.names), batch.data.shape[2])) if batch.noise is None else batch.noise.copy()
        known[np.ix_(noisier, np.array(scorer.setting.measured))] = own[noisier]
        batches.append(replace(batch, noise=known) if noisier.any() else batch)
        names |= dict.fromkeys(name for name, is_so in zip(batch.names, noisier, strict=True) if is_so)
    notes = [NOISIER.format(names=", ".join(names))] if names else []
    return replace(scorer, test=tuple(batches)), notes


def _only_noisier(scorer: Scorer, item: Fit, batch: Batch) -> tuple[FloatArray, BoolArray]:
    """Return the noise of each recording over the noise model's (recording, measured sensor), and which are only
    noisier.
    """
    noise_model, (measured,) = scorer.noise_model, columns_of((batch,), scorer.setting.measured)
    cost = least_cost(scorer.model(item), (), measured, noise_model.roles)
    usual = np.broadcast_to(measured.sigma(noise_model)[:, 0], (len(batch.names), len(noise_model.sensors)))
    (free,) = without_load_response(scorer.setting.nominal, (replace(measured, noise=None),), noise_model.outputs)
    own = np.stack(
        [
            noise_of_recordings((free.take([number]),), noise_model.rate, scorer.setting.band)
            for number in range(len(batch.names))
        ]
    )
    louder = np.mean((own / usual) ** 2, axis=1)
    expected = louder * batch.samples * batch.share * len(noise_model.sensors)
    return own / noise_model.sigma, (louder > VERDICT.max_near_ratio**2) & (
        cost <= VERDICT.max_near_ratio**2 * expected
    )
