"""Where sensors seem to be, if nothing on the list explains the recordings: two exchanged, or one at another place."""

from dataclasses import dataclass, replace
from itertools import combinations
from typing import cast

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.directions import AnyDirection, direction_words
from fe_models.recordings import Sensor
from fe_models.structure import Direction
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.outcome.changed_dataset import taken_away
from hybrid.diagnosis.outcome.config import MENTION
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.batches import columns_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import drifted


@dataclass(frozen=True)
class _Mounting:
    """The fitted ``sensors`` (sensor,) with nodes and directions that they may have, told in ``words``."""

    words: str
    sensors: tuple[Sensor, ...]


def mounting_of(item: Fit, noise_model: NoiseModel) -> str | None:
    """Return in a sentence how sensors seem to be mounted; None where no such error explains what the model leaves.

    ``item``: a fit without any cause. What sensors so mounted would show is held against the recordings with the drawn
    structure first, and the best of these fitted.
    """
    if not item.hypothesis.is_linear:
        return None
    drawn = np.zeros_like(item.theta)

    def fitted(mounting: _Mounting, **options: int) -> Fit | None:
        there = replace(noise_model, sensors=mounting.sensors)
        return fit(item.hypothesis, drawn, item.batches, there, item.states, **options)

    trials = [*_exchanged(noise_model.sensors), *_moved(item, drawn, noise_model)]
    tried = parallel_map(lambda trial: fitted(trial, iterations=0), trials)
    costs = [np.inf if found is None else found.cost for found in tried]
    if not costs:
        return None
    best = trials[int(np.argmin(costs))]
    gain = taken_away(fitted(best), item)
    return None if gain is None else f"{best.words} {gain}: check cables and names"


def _exchanged(sensors: tuple[Sensor, ...]) -> list[_Mounting]:
    """Return each two sensors of one quantity in each other's place."""
    found = []
    for i, j in combinations(range(len(sensors)), 2):
        one, other = sensors[i], sensors[j]
        if one.quantity == other.quantity:
            placed = list(sensors)
            placed[i], placed[j] = _at(one, other.node, other.direction), _at(other, one.node, one.direction)
            found.append(_Mounting(f"sensors {one.name} and {other.name} in each other's place", tuple(placed)))
    return found


def _moved(item: Fit, theta: FloatArray, noise_model: NoiseModel) -> list[_Mounting]:
    """Return each sensor at the place whose motion is nearest to its channel, as the others tell that motion."""
    found = []
    for position, sensor in enumerate(noise_model.sensors) if len(noise_model.sensors) > 1 else ():
        others = tuple(i for i in range(len(noise_model.sensors)) if i != position)
        rest = NoiseModel(
            tuple(noise_model.sensors[i] for i in others), noise_model.rate, noise_model.sigma[list(others)]
        )
        told = fit(item.hypothesis, theta, columns_of(item.batches, others), rest, item.states, iterations=0)
        if told is None:
            continue
        places = _places(item, sensor)
        differ = _differences(told, places, tuple(batch.data[..., [position]] for batch in item.batches), rest)
        nearest = int(np.argmin(differ))
        own = places.index(sensor)
        if differ[nearest] < MENTION.max_moved_share * differ[own]:
            node, direction = places[nearest].node, places[nearest].direction
            placed = tuple(_at(s, node, direction) if s is sensor else s for s in noise_model.sensors)
            there, said = direction_words(direction), direction_words(sensor.direction)
            words = f"sensor {sensor.name} at node {node} in {there}, not at node {sensor.node} in {said},"
            found.append(_Mounting(words, placed))
    return found


def _places(item: Fit, sensor: Sensor) -> list[Sensor]:
    """Return a sensor where it is said to be, and at each node of the structure along each axis that it moves in."""
    nominal = item.hypothesis.nominal
    dofs, nodes = nominal.dofs, len(nominal.structure.nodes)
    rows = [row for row in dofs.free_rows if dofs.node[row] <= nodes and dofs.direction[row] != "rz"]
    return [sensor, *(_at(sensor, int(dofs.node[row]), cast(Direction, str(dofs.direction[row]))) for row in rows)]


def _differences(
    told: Fit, places: list[Sensor], channels: tuple[FloatArray, ...], noise_model: NoiseModel
) -> FloatArray:
    """Return how much ``channels`` (recording, time, 1) differ from the motion at each of the ``places`` (place,)."""
    system = system_of(told.hypothesis, told.theta[None], SensorOutputs.faultless(tuple(places), noise_model.rate))
    found = np.zeros(len(places))
    for batch, states, channel in zip(told.batches, told.states, channels, strict=True):
        shown = respond(system, states[None], batch.samples, batch.loads) + drifted(system, batch.begins)
        found += np.square(shown[0] - channel).sum(axis=(0, 1))
    return found


def _at(sensor: Sensor, node: int, direction: AnyDirection) -> Sensor:
    return replace(sensor, node=node, direction=direction)
