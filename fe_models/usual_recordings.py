"""How simulated recordings of each kind are made where nothing is said: one table, for Python and the command."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from fe_models.synthetic import Acquisition

LOWPASS_SHARE = 0.3
"""Of the sampling rate: that of the laboratory bridge."""


@dataclass(frozen=True)
class Usual:
    """``sampling_rate`` (Hz), ``duration`` (s), None where a file says it, and whether a low-pass acts."""

    sampling_rate: float
    duration: float | None
    filtered: bool


class Kind(Enum):
    """What moves a structure in simulated recordings, and what is usual then."""

    RELEASED = Usual(100.0, 20.0, filtered=True)
    FREE = Usual(10.0, 50.0, filtered=False)
    DRIVEN = Usual(100.0, None, filtered=False)

    def duration(self, wish: float | None) -> float:
        """Return the length (s) of recordings that do not have that of what drives them."""
        usual = self.value.duration or 0.0
        return usual if wish is None else wish

    def acquisition(
        self,
        sampling_rate: float | None = None,
        lowpass: float | None = None,
        noise: float | Mapping[str, float] | None = None,
    ) -> Acquisition:
        """Return how recordings are made; what is None follows from what is not. ``lowpass`` 0: none.

        The low-pass is `LOWPASS_SHARE` of the sampling rate; a sampling rate that is not given goes by a low-pass that
        the usual one is too slow for, but where what drives the structure has one value a sample.
        """
        rate = self.value.sampling_rate if sampling_rate is None else sampling_rate
        if lowpass is None:
            lowpass = LOWPASS_SHARE * rate if self.value.filtered else 0.0
        elif sampling_rate is None and lowpass >= rate / 2 and self is not Kind.DRIVEN:
            rate = lowpass / LOWPASS_SHARE
        return Acquisition(rate, lowpass or None, Acquisition.noise if noise is None else noise)
