"""What the product is measured against, each in the same run; `scripts/benchmark.py` prints it."""
