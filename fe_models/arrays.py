"""Types of arrays, and a number next to nothing."""

import numpy as np
from numpy.typing import NDArray

BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]
FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

TINY = 1e-300  # instead of a division by zero or its logarithm: the reciprocal times any datum is finite
