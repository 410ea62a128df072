"""How often answers like one were right, on simulated structures whose truth was opened afterwards."""
