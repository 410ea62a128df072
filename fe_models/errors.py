"""The one exception for bad input: it carries every fault of that input, one line each."""

from collections.abc import Iterable


class InputError(ValueError):
    """Input that cannot be used. ``faults`` holds one sentence a fault: what is wrong, where, what was expected."""

    def __init__(self, faults: str | Iterable[str]) -> None:
        self.faults: tuple[str, ...] = (faults,) if isinstance(faults, str) else tuple(faults)
        super().__init__("\n".join(self.faults))


def raise_faults(faults: Iterable[str]) -> None:
    """Raise one `InputError` with all ``faults``, or nothing when there are none."""
    lines = tuple(faults)
    if lines:
        raise InputError(lines)
