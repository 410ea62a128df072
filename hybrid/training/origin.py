"""What a trained model was made from."""

from dataclasses import dataclass

from fe_models.linear import ModalModel
from fe_models.recordings import Sensor
from fe_models.structure import Structure
from hybrid.neural_modal_ode.connectors import Connectors


@dataclass(frozen=True)
class Origin:
    """What a model was made from, besides its configuration.

    ``structure`` is None for a model of the user's own matrices. ``data_digest`` is that of the training windows;
    ``sampling_rate`` and ``lowpass`` (Hz) are those of the recordings.
    """

    structure: Structure | None
    modal: ModalModel
    sensors: tuple[Sensor, ...]
    sampling_rate: float
    kept: tuple[str, ...]
    left_out: tuple[str, ...]
    unexplained: float | None
    data_digest: str
    connectors: Connectors | None = None
    lowpass: float | None = None
