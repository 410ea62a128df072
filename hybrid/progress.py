"""Progress: whoever waits for something long may hear of each step."""


def nothing() -> None:
    """Do nothing: the progress of who does not want to see any."""
