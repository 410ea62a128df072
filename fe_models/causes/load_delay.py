"""A load that was recorded late."""

from dataclasses import dataclass
from typing import ClassVar, Literal

from fe_models.causes.base import parameter
from fe_models.causes.candidate import LoadCandidate
from fe_models.causes.known import Known
from fe_models.causes.load_fault import LoadEffect

PRIOR_STD_PERIODS = 0.03  # of a period: the prior standard deviation of a delay


@dataclass(frozen=True)
class LoadDelay(LoadEffect):
    """A load whose clock is off: what was recorded is f(t - delay) of what acts, f(t); delay > 0 being late."""

    kind: ClassVar[str] = "load_delay"
    template: ClassVar[str] = "{place} is late by {delay} beside the sensors: check its clock"
    negative_template: ClassVar[str] = "{place} is early by {delay} beside the sensors: check its clock"
    quantity: ClassVar[Literal["gain", "delay"]] = "delay"
    delay: float = parameter("s")

    @classmethod
    def candidates(cls, known: Known) -> list[LoadCandidate]:
        """Return it of each load that was recorded by itself."""
        width = PRIOR_STD_PERIODS * known.period if known.loads else 0.0
        return [cls.of_channel(channel, neutral=0.0, width=width) for channel in known.loads]
