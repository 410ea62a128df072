"""Whether the sensors are too few, or the recordings too short, to tell how these begin; which sensor more would."""

from dataclasses import replace

import numpy as np

from fe_models.recordings import Sensor
from hybrid.diagnosis.fitting.fitting import Fit
from hybrid.diagnosis.fitting.forecasting import Model, leverage
from hybrid.diagnosis.outcome.advice import noise_of, possible_sensors, shown_by, size_of
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.recorded.gauge import Gauge, View
from hybrid.diagnosis.recorded.records import Batch

MANY = 2.0  # times what noise makes: a perfect model that misses by more says little of what is wrong
BETTER = 0.8  # of it: a sensor that does not bring it down so far is no help
HARDLY = (
    "the first fifth of the recordings hardly tells how they begin: even a perfect model would miss the rest by"
    " {floor:.1%} of a channel's range, {over:.1f} times what noise makes; what is wrong by less stays unseen, or is"
    " told as too weak to matter: record longer{help}"
)


def too_few(item: Fit, scorer: Scorer, floor: float) -> list[str]:
    """Return a note where initial states add more to the noise ``floor`` (NRMSE) of forecasts by a fit than noise does,
    with the added sensor that changes that most.
    """
    batch, view, model = scorer.shown, scorer.view, scorer.example_model(item)
    own = list(view.measured)
    over = _over(model, batch, view, own)
    if over <= MANY:
        return []
    plant, gauge = item.hypothesis.plant, scorer.gauge
    added = possible_sensors(plant, scorer.setting.dataset.sensors)
    sigma = noise_of(added, size_of(shown_by(item, added, gauge)), gauge, size_of(shown_by(item, gauge.sensors, gauge)))
    wider = [_with(view, sensor, float(noise)) for sensor, noise in zip(added, sigma, strict=True)]
    tried = [(_over(model, batch, more, own), number) for number, more in enumerate(wider)]
    least, number = min(tried, default=(over, 0))
    words = ""
    if least <= BETTER * over:
        best = added[number]
        place = f"{best.quantity} at node {best.node} in {best.direction}"
        words = f", or with a sensor of the {place}, which would bring it to {least:.1f} times"
    return [HARDLY.format(floor=floor, over=over, help=words)]


def _over(model: Model, batch: Batch, view: View, columns: list[int]) -> float:
    """Return the error that noise and initial states make of some ``columns``, over what noise alone makes."""
    return float(np.sqrt(1 + leverage(model, batch, view, view.gauge.sigma)[:, columns].mean() / batch.share))


def _with(view: View, sensor: Sensor, noise: float) -> View:
    """Return a view with one fitted sensor more."""
    gauge = Gauge((*view.gauge.sensors, sensor), view.gauge.rate, np.append(view.gauge.sigma, noise))
    return replace(view, sensors=(*view.sensors, sensor), measured=(*view.measured, len(view.sensors)), gauge=gauge)
