"""Functions compiled to machine code, which threads run side by side."""

from collections.abc import Callable
from typing import Any

from numba import njit


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function compiled to machine code, which is kept from one run to the next where that can be.

    Sums may be taken in any order, so that the processor's vectors serve; what is not finite stays so.
    """
    options = {"nogil": True, "error_model": "numpy", "fastmath": {"reassoc", "contract", "nsz"}}
    try:
        return njit(cache=True, **options)(function)
    except RuntimeError:  # no folder that can be written to
        return njit(**options)(function)
