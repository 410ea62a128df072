"""What all tests share."""

from threadpoolctl import threadpool_limits

threadpool_limits(1, "blas")  # the tests run in as many processes as there are cores
