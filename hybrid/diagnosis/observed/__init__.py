"""What the nominal simulation gets wrong, before a cause is named."""
