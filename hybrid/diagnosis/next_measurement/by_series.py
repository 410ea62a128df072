"""What to measure next by the search by time series."""

from functools import partial

import numpy as np

from fe_models.recordings import Sensor
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.next_measurement.hypotheses import rivals_among
from hybrid.diagnosis.next_measurement.in_excitations import considered, predictions_after
from hybrid.diagnosis.next_measurement.in_recordings import Sample, Surroundings, expected_in, predictions_of
from hybrid.diagnosis.next_measurement.information import Prediction
from hybrid.diagnosis.next_measurement.measurements import Measurement, moving_places, noise_of, possible_sensors
from hybrid.diagnosis.next_measurement.recommendation import ANYTHING, SENSORS, NextMeasurement, Predicted, recommended
from hybrid.diagnosis.recorded.noise_model import NoiseModel


def next_by_series(
    posterior: Posterior, searched: NoiseModel, present: tuple[Sensor, ...], listed: float = 1.0
) -> NextMeasurement | None:
    """Return what to measure next, None where the best hypothesis has no rival.

    ``searched``: with what counted as noise in the search, see `Evidence`; ``present``: all sensors, also those that
    are never fitted; ``listed``: the probability that what is wrong is on the list of causes.
    """
    rivals = rivals_among([fit.hypothesis.candidates for fit in posterior.fits], listed * posterior.probability)
    if rivals is None:
        return None
    fits = [posterior.fits[number] for number in rivals.numbers]
    around = Surroundings(searched, posterior.temper, posterior.widened)
    if len(fits) == 1:  # the same cause at other places, where it does the same whatever is measured
        return recommended(rivals, {})
    added = possible_sensors(fits[0].hypothesis.nominal, present)
    excited = _of_excitations(fits, around)
    return recommended(rivals, _of_sensors(fits, added, around) | excited, ANYTHING if excited else SENSORS)


def _of_sensors(fits: list[Fit], added: tuple[Sensor, ...], around: Surroundings) -> dict[Measurement, Predicted]:
    sample = Sample.of(fits[0])
    every = [expected_in(fit, added, around, sample) for fit in fits]
    expected = [own for own in every if own is not None]
    if not added or len(expected) < len(every):
        return {}
    means = np.concatenate([own.mean for own in expected[0]])  # (value, sensor)
    shown = np.concatenate([batch.data.reshape(-1, batch.data.shape[2]) for batch in fits[0].batches])
    sizes, own_sizes = (np.sqrt(np.mean(part**2, axis=0)) for part in (means, shown))
    noise = noise_of(added, sizes, around.noise_model.sensors, around.noise_model.sigma, own_sizes)
    noise = noise * np.sqrt(around.temper / sample.stands_for)
    return {
        Measurement.by(sensor): partial(predictions_of, expected, number, float(own))
        for number, (sensor, own) in enumerate(zip(added, noise, strict=True))
    }


def _of_excitations(fits: list[Fit], around: Surroundings) -> dict[Measurement, Predicted]:
    """Return what is predicted of pulls and blows; of none where force laws act in a frame, which takes minutes."""
    nominal = fits[0].hypothesis.nominal
    if not nominal.is_chain and not all(fit.hypothesis.is_linear for fit in fits):
        return {}
    excitations = considered(moving_places(nominal))
    found = predictions_after(fits, excitations, around)
    if found is None:
        return {}
    return {item: partial(list[Prediction], own) for item, own in zip(excitations, found, strict=True)}
