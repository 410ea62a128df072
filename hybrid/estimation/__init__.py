"""States and their uncertainty: from the first samples of a window to a forecast with its band."""
