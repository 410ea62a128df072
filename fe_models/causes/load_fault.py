"""What falsifies a known load: the fault of the instrument that recorded it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, Literal

from fe_models.causes.base import Cause
from fe_models.causes.candidate import UNBOUNDED, LoadCandidate
from fe_models.causes.known import LoadChannel
from fe_models.causes.load_name import LoadName
from fe_models.causes.searched import Searched


@dataclass(frozen=True)
class LoadEffect(Searched, Cause):
    """A fault in how a load, or the motion of the base, was recorded; ``quantity``: which number its parameter is."""

    quantity: ClassVar[Literal["gain", "delay"]]
    load: LoadName

    @classmethod
    def of_channel(
        cls, channel: LoadChannel, neutral: float, width: float, far: tuple[float, ...] = ()
    ) -> LoadCandidate:
        """Return the fault of what one instrument recorded, with its prior: see `Candidate`."""
        build: Callable[..., LoadEffect] = partial(cls, channel.load)
        return LoadCandidate(
            kind=cls.kind,
            location=_location(channel.load),
            names=tuple(build(neutral).units),
            build=build,
            neutral=(neutral,),
            width=(width,),
            lower=UNBOUNDED,
            far=far,
            twins=tuple(_location(twin) for twin in channel.twins),
            loads=channel.positions,
            quantity=cls.quantity,
        )


def _location(load: LoadName) -> dict[str, Any]:
    return {"load": list(load) if isinstance(load, tuple) else load}
