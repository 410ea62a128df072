"""The observability matrix of a linear system at samples, C A^k for k = 0, 1, ..., by doubling."""

from collections.abc import Callable
from typing import Any, TypeVar

Array = TypeVar("Array", bound=Any)


def observability_by_doubling(
    outputs: Array, transition: Array, samples: int, concatenate: Callable[..., Array]
) -> Array:
    """Return C A^k (..., time, sensor, state) of as many ``samples``, in log2 of them products.

    ``outputs`` C (..., 1, sensor, state), ``transition`` A from one sample to the next (..., 1, state, state), of NumPy
    or PyTorch, whose ``concatenate`` it takes.
    """
    rows = outputs
    while rows.shape[-3] < samples:
        rows = concatenate([rows, rows @ transition], axis=-3)
        transition = transition @ transition
    return rows[..., :samples, :, :]
