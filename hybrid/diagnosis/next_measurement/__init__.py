"""What to measure next: the sensor or the excitation that is expected to tell most about which hypothesis is right."""
