"""Frequency response functions of a structure's linear model."""

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray
from fe_models.assembly import linearise, unsupported
from fe_models.base_motion import base_force, rigid_motion
from fe_models.mechanisms import factorise
from fe_models.modes import natural_modes
from fe_models.recordings import QUANTITIES, Dataset
from fe_models.structure import Direction, Structure
from hybrid.identification.config import FREQUENCY_RESPONSE

Input = tuple[int, Direction] | tuple[float, float]
"""Node and direction of a load, or the vector (dx, dy) along which the base moves."""


def computed_response(
    structure: Structure, dataset: Dataset, inputs: tuple[Input, ...], frequencies: FloatArray
) -> ComplexArray:
    """Return the frequency response functions (line, input, sensor) of a structure's linear model.

    By its modes up to beyond the ``frequencies`` (Hz), and the static response of the others.
    """
    linear = linearise(structure)
    dofs, free = linear.dofs, linear.dofs.free_rows
    modal = natural_modes(linear, min(FREQUENCY_RESPONSE.max_modes, len(free)))
    rows = [dofs.row(sensor.node, sensor.direction) for sensor in dataset.sensors]
    mass = unsupported(structure)[0]
    turn = 2j * np.pi * frequencies[:, None]
    poles = modal.omega**2 + turn**2 + 2 * modal.damping_ratio * modal.omega * turn  # (line, mode)
    factors = factorise(linear.stiffness)
    found = np.empty((len(frequencies), len(inputs), len(rows)), dtype=complex)
    for number, item in enumerate(inputs):
        first, second = item
        pull = (
            dofs.pull([(int(first), second, 1.0)])
            if isinstance(second, str)
            else np.where(dofs.free, base_force(mass, dofs, (first, second)), 0.0)
        )
        fed = modal.shapes.T @ pull
        static = dofs.expand(factors.solve(pull[free])) - modal.shapes @ (fed / modal.omega**2)
        moved = (fed / poles) @ modal.shapes[rows].T + static[rows]  # (line, sensor)
        for position, sensor in enumerate(dataset.sensors):
            order = QUANTITIES.index(sensor.quantity)
            found[:, number, position] = moved[:, position] * turn[:, 0] ** order
            if not isinstance(second, str) and sensor.reference == "absolute":
                rigid = rigid_motion(dofs, (first, second))[rows[position]]
                found[:, number, position] += rigid * turn[:, 0] ** (order - 2)
    return found
