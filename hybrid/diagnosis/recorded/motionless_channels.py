"""Channels that hardly move, as along a column of a frame that sways: they show their mounting rather than motion."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.recordings import Dataset, Sensor
from fe_models.sensing import seen
from hybrid.diagnosis.recorded.config import MOTIONLESS

NOTE = (
    "sensor {name} hardly moves (by {share:.1g} of what {other} does, and little in any mode of the model), so that a"
    " sensor turned by a fraction of a degree would show as much: left out"
)


def without_motionless(dataset: Dataset, dofs: DofMap, shapes: FloatArray) -> tuple[Dataset, list[str]]:
    """Return the dataset without measured channels that hardly move, and a note on each.

    ``shapes`` (dof, mode): of the nominal modes that recordings can show. A channel is compared with those of the same
    quantity and unit, rotations apart; it is left out where both the recordings and the model have it at rest. One that
    the model has in motion may show another unit than it says, which is a finding.
    """
    size = np.sqrt(np.mean([r.data.var(axis=1).mean(axis=0) for r in dataset.select("train")], axis=0))  # (sensor,)
    shown = seen(dofs, dataset.sensors) @ shapes  # (sensor, mode)
    dropped, notes = set[int](), list[str]()
    for alike in _alike(dataset.sensors):
        loudest = max(alike, key=lambda column: size[column])
        reach = {column: float(np.abs(shown[column]).max()) for column in alike}
        for column in alike if len(alike) > MOTIONLESS.min_others else ():
            recorded = size[column] / size[loudest]
            modelled = reach[column] / max(reach.values())
            if recorded < MOTIONLESS.max_motion_share and modelled < MOTIONLESS.max_shape_share:
                dropped.add(column)
                notes.append(
                    NOTE.format(name=dataset.sensors[column].name, share=recorded, other=dataset.sensors[loudest].name)
                )
    if not dropped:
        return dataset, []
    kept = [column for column in range(len(dataset.sensors)) if column not in dropped]
    recordings = tuple(replace(recording, data=recording.data[..., kept]) for recording in dataset.recordings)
    return replace(dataset, sensors=tuple(dataset.sensors[i] for i in kept), recordings=recordings), notes


def _alike(sensors: tuple[Sensor, ...]) -> list[list[int]]:
    """Return the columns of the measured sensors whose channels can be compared, group by group."""
    groups = dict[tuple[str, str], list[int]]()
    for column, sensor in enumerate(sensors):
        if sensor.role == "measured" and not sensor.turns:
            groups.setdefault((sensor.quantity, sensor.unit), []).append(column)
    return list(groups.values())
