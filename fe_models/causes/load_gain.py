"""A load that was recorded with a wrong scale."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from fe_models.causes.base import parameter
from fe_models.causes.candidate import LoadCandidate
from fe_models.causes.known import Known
from fe_models.causes.load_fault import LoadEffect

PRIOR_STD = 0.3  # the prior standard deviation of a gain about one
REVERSED_GAIN = -1.0  # the gain of a load cell that is mounted, or counted, the other way round


@dataclass(frozen=True)
class LoadGain(LoadEffect):
    """A load with a wrong scale: what was recorded is ``factor`` times what acts. Negative: of the other sign."""

    kind: ClassVar[str] = "load_gain"
    template: ClassVar[str] = "{place} is {factor} times what acts: check its unit, calibration and sign"
    quantity: ClassVar[Literal["gain", "delay"]] = "gain"
    factor: float = parameter("1")

    @classmethod
    def candidates(cls, known: Known) -> list[LoadCandidate]:
        """Return it of each load that was recorded by itself."""
        return [cls.of_channel(channel, neutral=1.0, width=PRIOR_STD, far=(REVERSED_GAIN,)) for channel in known.loads]
