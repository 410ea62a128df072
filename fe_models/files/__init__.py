"""Everything read from and written to disk: structures, matrices, datasets, recordings, runs."""
