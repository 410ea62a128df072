"""Where sensors seem to be, if nothing on the list explains the recordings: two exchanged, or one at another place."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Sensor
from hybrid.diagnosis.fitting.fitting import Fit, fit
from hybrid.diagnosis.outcome.otherwise import taken_away
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.recorded.readout import Readout
from hybrid.diagnosis.recorded.records import columns_of
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.side_by_side import side_by_side
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import drifted

NEARER = 0.5  # of what a channel differs by from its own place: another one must differ by less


@dataclass(frozen=True)
class _Mounting:
    """The fitted ``sensors`` (sensor,) with nodes and directions that they may have, told in ``words``."""

    words: str
    sensors: tuple[Sensor, ...]


def mounting_of(item: Fit, gauge: Gauge) -> str | None:
    """Return in a sentence how sensors seem to be mounted; None where no such error explains what the model leaves.

    ``item``: a fit without any cause. What sensors so mounted would show is held against the recordings with the drawn
    structure first, and the best of these fitted.
    """
    if not item.hypothesis.is_linear:
        return None
    drawn = np.zeros_like(item.theta)

    def fitted(mounting: _Mounting, **options: int) -> Fit | None:
        there = replace(gauge, sensors=mounting.sensors)
        return fit(item.hypothesis, drawn, item.batches, there, item.states, **options)

    trials = [*_exchanged(gauge.sensors), *_moved(item, drawn, gauge)]
    tried = side_by_side(lambda trial: fitted(trial, iterations=0), trials)
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


def _moved(item: Fit, theta: FloatArray, gauge: Gauge) -> list[_Mounting]:
    """Return each sensor at the place whose motion is nearest to its channel, as the others tell that motion."""
    found = []
    for position, sensor in enumerate(gauge.sensors) if len(gauge.sensors) > 1 else ():
        others = tuple(i for i in range(len(gauge.sensors)) if i != position)
        rest = Gauge(tuple(gauge.sensors[i] for i in others), gauge.rate, gauge.sigma[list(others)])
        told = fit(item.hypothesis, theta, columns_of(item.batches, others), rest, item.states, iterations=0)
        if told is None:
            continue
        places = _places(item, sensor)
        differ = _differences(told, places, tuple(batch.data[..., [position]] for batch in item.batches), rest)
        nearest = int(np.argmin(differ))
        own = [(place.node, place.direction) for place in places].index((sensor.node, sensor.direction))
        if differ[nearest] < NEARER * differ[own]:
            node, direction = places[nearest].node, places[nearest].direction
            placed = tuple(_at(s, node, direction) if s is sensor else s for s in gauge.sensors)
            words = (
                f"sensor {sensor.name} at node {node} in {direction}, not at node {sensor.node} in {sensor.direction},"
            )
            found.append(_Mounting(words, placed))
    return found


def _places(item: Fit, sensor: Sensor) -> list[Sensor]:
    """Return a sensor at each node of the structure in each direction that a displacement may have there."""
    plant = item.hypothesis.plant
    dofs, nodes = plant.dofs, len(plant.structure.nodes)
    rows = [row for row in dofs.free_rows if dofs.node[row] <= nodes and dofs.direction[row] != "rz"]
    return [_at(sensor, int(dofs.node[row]), str(dofs.direction[row])) for row in rows]


def _differences(told: Fit, places: list[Sensor], channels: tuple[FloatArray, ...], gauge: Gauge) -> FloatArray:
    """Return how much ``channels`` (recording, time, 1) differ from the motion at each of the ``places`` (place,)."""
    system = system_of(told.hypothesis, told.theta[None], Readout.faultless(tuple(places), gauge.rate))
    found = np.zeros(len(places))
    for batch, states, channel in zip(told.batches, told.states, channels, strict=True):
        shown = respond(system, states[None], batch.samples, batch.loads) + drifted(system, batch.begins)
        found += np.square(shown[0] - channel).sum(axis=(0, 1))
    return found


def _at(sensor: Sensor, node: int, direction: str) -> Sensor:
    return replace(sensor, node=node, direction=direction)  # type: ignore[arg-type]
