"""Modal expansion: a sensor estimated from all others, instant by instant, by the FE model's shapes alone.

    y = Phi_y q,   q = least squares of Phi_x q = x   (the smallest, where there are more modes than other sensors)

It is given the other sensors at every instant, where a forecast sees the first samples only: a bound on what the shapes
give rather than a forecast (O'Callahan, SEREP, IMAC 1989).
"""

from collections.abc import Sequence

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.linear import ModalModel
from fe_models.recordings import Sensor
from hybrid.neural_modal_ode.decoder import sensor_shapes


def expand(modal: ModalModel, sensors: Sequence[Sensor], windows: FloatArray, modes: int) -> FloatArray:
    """Return windows (window, time, sensor) with the held-out sensors estimated from the measured ones by ``modes``
    modes.

    `InputError` where the sensors are of different quantities, which no shape relates at one instant.
    """
    quantities = sorted({sensor.quantity for sensor in sensors})
    if len(quantities) > 1:
        raise InputError(f"modal expansion needs sensors of one quantity, found {', '.join(quantities)}")
    shapes = sensor_shapes(modal, sensors)[:, :modes]  # (sensor, mode)
    measured = [i for i, sensor in enumerate(sensors) if sensor.role == "measured"]
    held_out = [i for i, sensor in enumerate(sensors) if sensor.role == "held_out"]
    q = windows[:, :, measured] @ np.linalg.pinv(shapes[measured]).T  # (window, time, mode)
    expanded = windows.copy()
    expanded[:, :, held_out] = q @ shapes[held_out].T
    return expanded
