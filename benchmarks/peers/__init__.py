"""What the diagnosis is held against: other ways to select a cause, on the same recordings."""
