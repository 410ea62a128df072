"""Whether the sensors are too few, or the recordings too short, to tell how these begin; which sensor more would."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Sensor
from hybrid.diagnosis.fitting.forecast_score import ForecastModel, leverage
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.next_measurement.measurements import noise_of, possible_sensors
from hybrid.diagnosis.outcome.config import MENTION
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel, SensorRoles
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import drifted

HARDLY = (
    "the first fifth of the recordings hardly tells how they begin: even a perfect model would miss the rest by"
    " {floor:.1%} of a channel's range, {over:.1f} times what noise makes; what is wrong by less stays unseen, or is"
    " told as too weak to matter: record longer{help}"
)


def too_few(item: Fit, scorer: Scorer, floor: float) -> list[str]:
    """Return a note where initial states add more to the noise ``floor`` (NRMSE) of forecasts by a fit than noise does,
    with the added sensor that changes that most.
    """
    batch, roles, model = scorer.shown, scorer.roles, scorer.example_model(item)
    own = list(roles.measured)
    over = _over(model, batch, roles, own)
    if over <= MENTION.max_imperfect_ratio:
        return []
    nominal, noise_model = item.hypothesis.nominal, scorer.noise_model
    added = possible_sensors(nominal, scorer.setting.dataset.sensors)
    sizes, own_sizes = (_size_shown(item, sensors, noise_model) for sensors in (added, noise_model.sensors))
    sigma = noise_of(added, sizes, noise_model.sensors, noise_model.sigma, own_sizes)
    wider = [_with(roles, sensor, float(noise)) for sensor, noise in zip(added, sigma, strict=True)]
    tried = [(_over(model, batch, more, own), number) for number, more in enumerate(wider)]
    least, number = min(tried, default=(over, 0))
    words = ""
    if least <= MENTION.max_helped_share * over:
        best = added[number]
        place = f"{best.quantity} at node {best.node} in {best.direction}"
        words = f", or with a sensor of the {place}, which would bring it to {least:.1f} times"
    return [HARDLY.format(floor=floor, over=over, help=words)]


def _size_shown(item: Fit, sensors: tuple[Sensor, ...], noise_model: NoiseModel) -> FloatArray:
    """Return the rms (sensor,) of what ``sensors`` would show of a fit without noise, over all recordings."""
    present = {sensor.name: position for position, sensor in enumerate(noise_model.sensors)}
    outputs = SensorOutputs(sensors, noise_model.rate, tuple(present.get(sensor.name, -1) for sensor in sensors))
    squares = list[FloatArray]()
    for batch, states in zip(item.batches, item.states, strict=True):
        theta = item.theta[item.hypothesis.parameters_of(batch.off)]
        system = system_of(item.hypothesis.less(batch.off), theta[None], outputs)
        y = (respond(system, states[None], batch.samples, batch.loads) + drifted(system, batch.begins))[0]
        squares += list(y**2)
    return np.sqrt(np.concatenate(squares).mean(axis=0))


def _over(model: ForecastModel, batch: Batch, roles: SensorRoles, columns: list[int]) -> float:
    """Return the error that noise and initial states make of some ``columns``, over what noise alone makes."""
    return float(np.sqrt(1 + leverage(model, batch, roles, roles.noise_model.sigma)[:, columns].mean() / batch.share))


def _with(roles: SensorRoles, sensor: Sensor, noise: float) -> SensorRoles:
    """Return a view with one fitted sensor more."""
    noise_model = NoiseModel(
        (*roles.noise_model.sensors, sensor), roles.noise_model.rate, np.append(roles.noise_model.sigma, noise)
    )
    return replace(
        roles, sensors=(*roles.sensors, sensor), measured=(*roles.measured, len(roles.sensors)), noise_model=noise_model
    )
