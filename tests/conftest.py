"""What all tests share."""

import os

# The tests run in as many processes as there are cores: more threads, also in what they start, wait for one another.
# Torch takes their number from here; BLAS is limited once it is there.
os.environ.setdefault("OMP_NUM_THREADS", "1")

import scipy.linalg  # noqa: F401  brings a BLAS of its own
from threadpoolctl import threadpool_limits

threadpool_limits(1, "blas")
