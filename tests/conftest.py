"""What all tests share."""

import scipy.linalg  # noqa: F401  brings a BLAS of its own, which is limited only once it is there
from threadpoolctl import threadpool_limits

threadpool_limits(1, "blas")  # the tests run in as many processes as there are cores
