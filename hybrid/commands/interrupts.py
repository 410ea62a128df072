"""Ctrl-C: one line, within a second, whatever runs.

Python hears a signal only between two of its own steps, which a large factorisation or a simulation may be minutes
apart. So a thread hears it as well, and ends the process where nothing else does: results are exchanged whole, states
of trainings written whole, and processes that work for this one end with it.
"""

import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread
from types import FrameType

WHOLE = "results written before are whole"
INTERRUPTED_STATUS = 130  # of a command that Ctrl-C ends: 128 and the number of SIGINT
# s: for a command that can end in its own words, of which it has worked some itself: a busy machine is slow to let it
PATIENCE, WORKED = 0.8, 0.4
MOST_PATIENCE = 5.0  # s: for one that waits for something


@contextmanager
def interrupts_exit() -> Iterator[None]:
    """Turn Ctrl-C inside the block into one line on stderr and the exit status 130.

    Code that is not Python's own may wrap the interrupt into an exception of its own, which is then no fault.
    """
    if threading.current_thread() is not threading.main_thread():  # where no signal arrives, nor may be waited for
        yield
        return
    interrupted: list[int] = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        interrupted.append(number)
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGINT, interrupt)
    try:
        with _ended_soon():
            yield
    except BaseException as error:
        if isinstance(error, SystemExit) or not (interrupted or isinstance(error, KeyboardInterrupt)):
            raise
        print(f"Interrupted; {WHOLE}.", file=sys.stderr)
        raise SystemExit(INTERRUPTED_STATUS) from None
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def _ended_soon() -> Iterator[None]:
    """End the process where Ctrl-C has not ended the block soon."""
    heard, told = os.pipe()
    os.set_blocking(told, False)  # as `set_wakeup_fd` asks for
    left = Event()
    watch = Thread(target=_watch, args=(heard, left), daemon=True)
    watch.start()
    before = signal.set_wakeup_fd(told, warn_on_full_buffer=False)
    try:
        yield
    finally:
        left.set()
        signal.set_wakeup_fd(before)
        os.close(told)  # the end of what the thread reads
        watch.join()


def _watch(heard: int, left: Event) -> None:
    with os.fdopen(heard, "rb", buffering=0) as signals:
        while number := signals.read(1):
            if number[0] == signal.SIGINT and not _ends(left):
                os.write(2, f"Interrupted; {WHOLE}.\n".encode())
                os._exit(INTERRUPTED_STATUS)


def _ends(left: Event) -> bool:
    """Return whether the command ends by itself after Ctrl-C."""
    begun, worked = time.monotonic(), time.process_time()
    if left.wait(PATIENCE):
        return True
    while time.process_time() - worked < WORKED and time.monotonic() - begun < MOST_PATIENCE:
        if left.wait(PATIENCE / 8):
            return True
    return False
