"""The structure as its user drew it, and what its user considers uncertain."""
