"""Functions compiled to machine code, which threads run side by side."""

from collections.abc import Callable
from typing import Any

from numba import njit

from fe_models.arrays import FloatArray


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function compiled to machine code, which is kept from one run to the next where that can be.

    Sums may be taken in any order, so that the processor's vectors serve; what is not finite stays so.
    """
    options = {"nogil": True, "error_model": "numpy", "fastmath": {"reassoc", "contract", "nsz"}}
    try:
        return njit(cache=True, **options)(function)
    except RuntimeError:  # no folder that can be written to
        return njit(**options)(function)


@compiled
def put_vector(values: FloatArray, to: FloatArray) -> None:
    """Write ``values`` (entry,) to another array, in compiled code: a slice that is assigned to takes the compiler five
    seconds, most of them for the words of an error.
    """
    for i in range(len(values)):
        to[i] = values[i]


@compiled
def put_matrix(values: FloatArray, to: FloatArray) -> None:
    """Write ``values`` (row, column) to another array, as `put_vector` does."""
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            to[i, j] = values[i, j]
