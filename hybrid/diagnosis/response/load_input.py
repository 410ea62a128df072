"""How forces whose course is given enter a system: known loads, and what geometry exerts along a motion."""

from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.interpolant import ORDERS
from fe_models.recordings import Sensor, of_each_quantity
from hybrid.diagnosis.nominal.loads import ForcePlace, OnBase
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response.reduced_model import ReducedModel
from hybrid.diagnosis.response.system import LoadInput


def feedthrough(picked: FloatArray, feed: FloatArray, sensors: tuple[Sensor, ...]) -> FloatArray:
    """Return what ``sensors`` show of forces before anything has moved, (..., sensor, force): accelerations.

    ``picked`` (..., sensor, mode): the shapes there; ``feed`` (..., mode, force): the acceleration of each mode.
    """
    pushed = of_each_quantity(sensors)[2]
    return np.where(pushed[:, None], picked @ feed, 0.0)


def load_input_of(
    places: tuple[ForcePlace, ...],
    pulls: FloatArray,
    bent: FloatArray,
    laws: FloatArray,
    reduced: ReducedModel,
    inverse: Any,
    nominal: NominalModel,
    sensors: tuple[Sensor, ...],
) -> LoadInput:
    """Return how forces along ``pulls`` (place, dof) enter a ``reduced`` system, and what ``sensors`` show at once.

    ``bent`` (term, dof, place): how modes that are not followed move under each force, its second derivative and so on;
    ``laws`` (law, dof): pulls of the force laws, which answer to that; ``inverse`` of the mass.
    """
    n, rows, variants = reduced.mass.shape[1], nominal.rows(sensors), len(inverse)
    feed = np.zeros((variants, 2 * n, len(pulls)))
    feed[:, n:] = reduced.feed(list(pulls), inverse)
    on_base = [(number, place) for number, place in enumerate(places) if isinstance(place, OnBase)]
    for number, place in on_base:  # the mass that it carries along changes with that of the variants
        if place.drives:
            feed[:, n:, number] = -np.einsum("pij,pj->pi", inverse, reduced.carried[..., number])
    direct = feedthrough(rows @ reduced.shapes, feed[:, n:], sensors)
    for number, place in on_base:
        direct[..., number] += _shown_of_base(place, sensors) * (rows @ nominal.rigid_motions[:, number])
    shown, stretch = np.zeros((ORDERS, len(rows), len(pulls))), np.zeros((ORDERS, len(laws), len(pulls)))
    for term, moved in enumerate(bent):
        stretch[2 * term] = laws @ moved
        for derivative, own in enumerate(of_each_quantity(sensors)):
            shown[2 * term + derivative] += own[:, None] * (rows @ moved)
    as_recorded = np.ones((variants, len(pulls))), np.zeros((variants, len(pulls)))
    return LoadInput(places, feed, direct, shown, stretch, *as_recorded)


def _shown_of_base(place: OnBase, sensors: tuple[Sensor, ...]) -> FloatArray:
    """Return one for each of the ``sensors`` (sensor,) that shows a quantity of the base's motion, zero for others."""
    shows = [sensor.reference == "absolute" and sensor.quantity == place.quantity for sensor in sensors]
    return np.array(shows, dtype=float)
