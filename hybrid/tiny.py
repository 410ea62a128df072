"""A number next to nothing, instead of a division by zero or of its logarithm."""

TINY = 1e-300  # far from the least normal number, so that its reciprocal times any datum is finite
