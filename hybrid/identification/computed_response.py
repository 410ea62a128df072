"""Frequency response functions of a linear model."""

from collections.abc import Sequence

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray
from fe_models.assembly import linearise
from fe_models.base_motion import Along
from fe_models.causes import ForceLaw
from fe_models.causes.laws import effects_of
from fe_models.dof_map import DofMap
from fe_models.dofs import dofs_of
from fe_models.drive import inertia
from fe_models.files.known_motion import NO_EFFECT
from fe_models.files.recording_checks import check_place, check_sensor
from fe_models.linear import LinearModel
from fe_models.mechanisms import factorise
from fe_models.mode_count import mode_count
from fe_models.modes import natural_modes
from fe_models.recordings import QUANTITIES, Sensor
from fe_models.sensing import seen
from fe_models.structure import Direction, Structure
from hybrid.identification.config import FREQUENCY_RESPONSE

Input = tuple[int, Direction] | Along
"""Node and direction of a load, or the vector (dx, dy), in space (dx, dy, dz), along which the base moves."""


def computed_response(
    model: Structure | LinearModel, sensors: Sequence[Sensor], inputs: Sequence[Input], frequencies: FloatArray
) -> ComplexArray:
    """Return the frequency response functions (line, input, sensor) of a model, of a structure for small motion.

    By its modes up to beyond the ``frequencies`` (Hz), and the static response of the others.
    """
    linear = linearise(model) if isinstance(model, Structure) else model
    dofs, free = linear.dofs, linear.dofs.free
    modal = natural_modes(linear, min(FREQUENCY_RESPONSE.max_modes, mode_count(linear)))
    picked = seen(dofs, sensors)
    turn = 2j * np.pi * frequencies[:, None]
    poles = modal.omega**2 + turn**2 + 2 * modal.damping_ratio * modal.omega * turn  # (line, mode)
    factors = factorise(linear.stiffness)
    found = np.empty((len(frequencies), len(inputs), len(sensors)), dtype=complex)
    for number, item in enumerate(inputs):
        along = base_along(item)
        pull = dofs.gathered(_load(dofs, item) if along is None else inertia(model, along))  # (free,)
        fed = modal.shapes[free].T @ pull
        static = dofs.expand(factors.solve(pull)) - modal.shapes @ (fed / modal.omega**2)
        moved = (fed / poles) @ (picked @ modal.shapes).T + picked @ static  # (line, sensor)
        for position, sensor in enumerate(sensors):
            order = QUANTITIES.index(sensor.quantity)
            found[:, number, position] = moved[:, position] * turn[:, 0] ** order
            if along is not None and sensor.reference == "absolute":
                found[:, number, position] += sensor.shown_of(along) * turn[:, 0] ** (order - 2)
    return found


def base_along(item: Input) -> Along | None:
    """Return the vector along which the base moves; None of a load."""
    return None if isinstance(item[1], str) else item


def _load(dofs: DofMap, item: Input) -> FloatArray:
    """Return the unit force (dof,) of a load."""
    return dofs.pull([(int(item[0]), str(item[1]), 1.0)])


def input_name(item: Input) -> str:
    """Return what an input is, in words."""
    along = base_along(item)
    if along is None:
        return f"load at node {item[0]} in {item[1]}"
    return f"base along ({', '.join(f'{part:.3g}' for part in along)})"


def misplaced(model: Structure | LinearModel, sensors: Sequence[Sensor], inputs: Sequence[Input]) -> list[str]:
    """Return which sensors and loads a model has no place for, a line each."""
    dofs = dofs_of(model)
    nodes = len(model.coordinates if isinstance(model, LinearModel) else model.nodes)
    faults = {f"sensor {sensor.name!r}": check_sensor(sensor, dofs, nodes) for sensor in sensors}
    for item in inputs:
        if base_along(item) is None:
            faults[input_name(item)] = check_place(int(item[0]), str(item[1]), dofs, nodes, NO_EFFECT)
    return [f"{what}: {fault}" for what, own in faults.items() for fault in own]


def laws_left_out(model: Structure | LinearModel) -> list[str]:
    """Return the kinds of force laws that a model carries, which are not in its functions."""
    if isinstance(model, LinearModel):
        return []
    return [effect.kind for effect in effects_of(model) if isinstance(effect, ForceLaw)]
