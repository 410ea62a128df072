"""A first look at a recording file: what is in it, what moved the structure, and a dataset to start from."""
