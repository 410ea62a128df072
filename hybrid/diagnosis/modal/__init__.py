"""Modal evidence: what natural frequencies, damping ratios and mode shapes say of a structure."""
