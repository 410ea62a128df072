"""Damping ratios that a dataset assumes in place of the structure's own."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.nominal import damping_ratios


def assumed_ratios(assumed: float | tuple[float, ...], modes: int, whole: bool = False) -> FloatArray:
    """Return the ratio of each of the ``modes`` (mode,) that are followed; `InputError` where a list does not fit.

    ``whole``: these are all that the structure has, so that a list must have all of them. Else there are as many as
    the recordings need, which nobody stated, and the last ratio given counts for the others.
    """
    given = np.atleast_1d(np.asarray(assumed, dtype=float))
    if not whole:
        given = np.append(given, np.full(max(modes - len(given), 0), given[-1]))
    return damping_ratios(tuple(given), modes)
