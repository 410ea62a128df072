"""An audit: evidences in closed form against nested sampling, and how well posteriors are calibrated."""
