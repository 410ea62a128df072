"""Standard output as a command writes to it: whoever stops listening, or cannot show a letter, stops no work."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO


class PatientStream:
    """A stream that takes text as long as somebody listens, and then lets it go.

    ``broken``: why it could not be written, where that is no listener's choice: a full disk.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.broken: OSError | None = None

    def write(self, text: str) -> int:
        """Write ``text``; return its length."""
        self._try(lambda: self._stream.write(text))
        return len(text)

    def flush(self) -> None:
        """Write what waits."""
        self._try(self._stream.flush)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _try(self, write: Any) -> None:
        try:
            write()
        except OSError as error:
            if not isinstance(error, BrokenPipeError):
                self.broken = error
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())  # what waits in the stream goes there, too
            os.close(nowhere)
            with suppress(OSError):
                self._stream.flush()


@contextmanager
def written_whatever() -> Iterator[None]:
    """Let stdout and stderr fail without stopping the block, whose end has exit status 1 where a disk was full.

    Streams that tests, notebooks and servers put in their place are left alone.
    """
    _open_closed()
    before, patient = (sys.stdout, sys.stderr), list[PatientStream]()
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None or stream is not getattr(sys, f"__{name}__"):
            continue
        stream.reconfigure(errors="backslashreplace")  # of letters that the terminal's encoding lacks
        patient.append(PatientStream(stream))
        setattr(sys, name, patient[-1])
    try:
        yield
    finally:
        for each in patient:
            each.flush()
        sys.stdout, sys.stderr = before
    broken = next((each.broken for each in patient if each.broken), None)
    if broken is not None:
        if sys.stderr is not None:
            with suppress(OSError):
                print(f"error: not all could be printed ({broken.strerror}); the results are whole", file=sys.stderr)
        raise SystemExit(1)


def _open_closed() -> None:
    """Let a closed stdout or stderr lead nowhere: else the next file that is opened has its number."""
    for number in (1, 2):
        try:
            os.fstat(number)
        except OSError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            if nowhere != number:
                os.dup2(nowhere, number)
                os.close(nowhere)
