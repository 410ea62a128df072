"""The door of `hybrid-modal`: Ctrl-C is one line from its first moment on, also while libraries are loaded."""

import os
import signal
from types import FrameType

from hybrid.commands.interrupts import INTERRUPTED_STATUS  # light


def main() -> None:
    """Run the command that the words of the command line name."""
    signal.signal(signal.SIGINT, _leave)
    from hybrid.commands.app import app  # loads what takes its time

    app()


def _leave(number: int, frame: FrameType | None) -> None:
    """End at once: nothing is begun yet, and an exception would come out of somebody's import."""
    os.write(2, b"Interrupted; nothing was begun.\n")
    os._exit(INTERRUPTED_STATUS)


if __name__ == "__main__":
    main()
