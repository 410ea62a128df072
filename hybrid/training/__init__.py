"""Training: from a dataset to a trained model, its run folder and its scores."""
