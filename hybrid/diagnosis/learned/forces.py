"""What a hybrid model learned, as plain numbers: its forecasts' errors and its forces at the places of a structure."""

from dataclasses import dataclass

from fe_models.arrays import FloatArray


@dataclass(frozen=True)
class PlaceForce:
    """The force (n,) learned at the place ``name``, at its elongations ``u`` (n,) m and rates ``v`` (n,) m/s.

    ``share``: what its mean square makes of that of the learned forces at all places, each as the acceleration it
    gives.
    """

    name: str
    u: FloatArray
    v: FloatArray
    force: FloatArray
    share: float


@dataclass(frozen=True)
class Learned:
    """A trained hybrid's forecasts: ``nrmse`` (recording, sensor) over the last 80 % of the test recordings.

    ``share``: of the mean square acceleration of its own motion from the starts of the training recordings, what was
    learned and is not the structure's. ``places``: the learned forces where the net is tied to places.
    """

    nrmse: FloatArray
    share: float
    places: tuple[PlaceForce, ...]
