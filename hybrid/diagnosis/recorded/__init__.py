"""The recordings as a diagnosis uses them: channels, batches, their noise."""
