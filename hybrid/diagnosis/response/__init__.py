"""What a hypothesis makes the sensors show."""
