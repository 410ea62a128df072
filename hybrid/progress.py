"""Progress: whoever waits for something long may be told of each step."""


def nothing() -> None:
    """Do nothing: the progress of who does not want to see any."""
