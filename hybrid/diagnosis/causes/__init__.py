"""Every cause at every place that it can have."""
