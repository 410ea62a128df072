"""What may be measured next: one more sensor, or one more recording after a pull or the blow of a hammer."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.places import MIN_MOTION_SHARE
from fe_models.directions import AnyDirection, direction_words
from fe_models.files.recording_checks import UNITS
from fe_models.recordings import Quantity, Sensor
from fe_models.structure import TRANSLATIONS, Direction
from hybrid.diagnosis.nominal.nominal_model import NominalModel

Kind = Literal["sensor", "pull", "hammer"]
OFFERED: tuple[Quantity, ...] = ("displacement", "acceleration")
INSTRUMENTS = {"displacement": "a displacement sensor", "acceleration": "an accelerometer"}


@dataclass(frozen=True)
class Measurement:
    """A ``sensor`` in recordings like those there are, or another recording of the sensors there are: after a "pull" at
    a node in a direction was let go, or a "hammer" that measures its force struck there.
    """

    kind: Kind
    node: int
    direction: AnyDirection
    quantity: Quantity | None = None

    @staticmethod
    def by(sensor: Sensor) -> "Measurement":
        """Return that of one more ``sensor``."""
        return Measurement("sensor", sensor.node, sensor.direction, sensor.quantity)

    @property
    def title(self) -> str:
        """What to do, as a name."""
        place = f"at node {self.node} in {direction_words(self.direction)}"
        if self.quantity is not None:
            return f"{INSTRUMENTS[self.quantity].split(' ', 1)[1]} {place}"
        return f"pull {place}, let go" if self.kind == "pull" else f"hammer {place}, its force measured"

    @property
    def words(self) -> str:
        """What to do, as the subject of a sentence."""
        place = f"node {self.node} in {direction_words(self.direction)}"
        if self.quantity is not None:
            return f"{INSTRUMENTS[self.quantity]} at {place}"
        if self.kind == "pull":
            return f"one more recording, of the free decay after a pull at {place} is let go,"
        return f"one more recording, of a blow at {place} with a hammer that measures its force,"


def moving_places(nominal: NominalModel) -> list[tuple[int, Direction]]:
    """Return the nodes and directions in which something moves that a file can name."""
    if nominal.coordinates is not None:
        places, moved = zip(*nominal.coordinates.pulls.items(), strict=True)
        size = np.abs(np.array(moved) @ nominal.modes[1]).max(axis=1)
    else:
        own = nominal.dofs.node <= len(nominal.structure.nodes)  # finer meshes have more, which no file can name
        places = tuple(zip(nominal.dofs.node[own].tolist(), nominal.dofs.direction[own].tolist(), strict=True))
        size = np.abs(nominal.modes[1][own]).max(axis=1)
    kept = size > MIN_MOTION_SHARE * size.max()
    return [place for place, felt in zip(places, kept, strict=True) if felt and place[1] in TRANSLATIONS]


def possible_sensors(nominal: NominalModel, present: tuple[Sensor, ...]) -> tuple[Sensor, ...]:
    """Return an accelerometer for each translation that moves and has none yet, and a displacement sensor where the
    ``present`` ones show displacements, too.
    """
    have = {(s.node, s.direction, s.quantity) for s in present}
    used = {s.quantity for s in present if not s.turns} | {"acceleration"}
    return tuple(
        Sensor(f"{quantity} {node} {direction}", node, direction, quantity, UNITS[quantity, False])
        for node, direction in moving_places(nominal)
        for quantity in OFFERED
        if quantity in used and (node, direction, quantity) not in have
    )


def noise_of(
    added: tuple[Sensor, ...], sizes: FloatArray, present: tuple[Sensor, ...], noise: FloatArray, shown: FloatArray
) -> FloatArray:
    """Return the noise (sensor,) to expect of ``added`` sensors: that of the ``present`` ones of their quantity.

    Where there are none, as large beside the largest channel as theirs: ``sizes`` of the added channels (sensor,),
    ``noise`` of the present ones and what is ``shown`` by these (sensor,).
    """
    wanted = np.array([sensor.quantity for sensor in added])
    measured = np.array(["rotation" if sensor.turns else sensor.quantity for sensor in present])
    relative, found = float(np.median(noise / shown)), np.zeros(len(added))
    for quantity in OFFERED:
        own, same = wanted == quantity, measured == quantity
        found[own] = np.median(noise[same]) if same.any() else relative * sizes[own].max(initial=0.0)
    return found
