"""Effects hidden in simulated recordings, diagnosed blind: how often that is right, beside peers on the same cases."""
