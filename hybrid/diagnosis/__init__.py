"""What a simulation gets wrong, and why."""
