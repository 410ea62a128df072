"""What recordings show over time that no mode does: force laws, and how much of the motion nothing explains."""
