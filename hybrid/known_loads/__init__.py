"""Known loads as they were sampled: behind the low-pass of the recordings, and of knocks what samples tell."""
