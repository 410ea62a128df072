"""What sensors see of a model's degrees of freedom."""

from collections.abc import Sequence

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.errors import raise_faults
from fe_models.recordings import Sensor


def seen(dofs: DofMap, sensors: Sequence[Sensor]) -> FloatArray:
    """Return what each sensor picks of the degrees of freedom, E (sensor, dof): along its axis one, or its direction's
    components.

    A component that the model has no degree of freedom for does not move. `InputError` with all sensors that see
    nothing.
    """
    picked, faults = np.zeros((len(sensors), len(dofs))), list[str]()
    for row, sensor in zip(picked, sensors, strict=True):
        missing = list[str]()
        for direction, part in sensor.components.items():
            try:
                row[dofs.row(sensor.node, direction)] = part
            except KeyError as error:
                missing.append(str(error.args[0]))
        if len(missing) == len(sensor.components):
            faults.append(f"sensor {sensor.name!r}: {'; '.join(missing)}")
    raise_faults(faults)
    return picked
