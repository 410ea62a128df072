"""What the blind cases of the chain and of the bridge draw alike."""

from collections.abc import Callable, Iterable

import numpy as np

from fe_models.causes import Cause, SensorDelay, SensorDrift, SensorGain, SlackCable, TimeIntegration
from fe_models.recordings import Sensor
from fe_models.response import Response
from fe_models.structure import Structure


def amount_between(smallest: float, largest: float, rng: np.random.Generator, size: float | None) -> float:
    """Return an amount; ``size`` from 0 to 1, even in its logarithm, leads from one to the other; None draws it."""
    share = rng.uniform() if size is None else size
    return smallest * (largest / smallest) ** share


def causes_apart(kinds: Iterable[str], draw: Callable[[str], Cause]) -> list[Cause]:
    """Return a cause of each of the ``kinds``, no two of one kind at one place."""
    causes: list[Cause] = []
    for kind in kinds:
        cause = draw(kind)
        while any(cause.location == other.location and cause.kind == other.kind for other in causes):
            cause = draw(kind)
        causes.append(cause)
    return causes


def slack_cable(element: int, amount: float, design: Structure, calm: Response) -> SlackCable:
    """Return a cable that does not take an ``amount`` of its largest compression in the ``calm`` motion."""
    law = SlackCable(element, 0.0).law(design)
    assert law is not None  # the drawn cables have their stiffness
    stretch = sum(c * calm.channel(node, direction, "displacement") for node, direction, c in law.pulls)
    return SlackCable(element, law.stiffness * (1 - amount) * float(np.quantile(-stretch, 0.999)))


def recording_cause(kind: str, amount: float, sign: float, sensor: Sensor, calm: Response) -> Cause | None:
    """Return a cause that is no force on the structure, with the scales of the ``calm`` motion; of others None."""
    match kind:
        case "sensor_gain":
            return SensorGain(sensor.name, 1 + sign * amount)
        case "sensor_delay":
            return SensorDelay(sensor.name, sign * amount)
        case "sensor_drift":
            channel = calm.shown(sensor)
            return SensorDrift(sensor.name, sign * amount * float(channel.std() / calm.time[-1]))
        case "time_integration":
            return TimeIntegration(amount)
    return None
