"""What ended a diagnosis of a fleet other than its input, as an engineer reads it."""

import signal

from pebble import ProcessExpired

HOUR = 3600.0  # s


def failure_of(error: Exception) -> str:
    """Return what an ``error`` of a task, or of its process, says: killed, given up, or what the work raised."""
    if isinstance(error, ProcessExpired):
        return _expired(error.exitcode)
    if isinstance(error, TimeoutError) and len(error.args) == 2:  # pebble's, with the limit in s
        limit = error.args[1]
        return f"it was given up after {f'{limit / HOUR:.3g} h' if limit >= HOUR else f'{limit:.3g} s'}"
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


def _expired(status: int) -> str:
    """Return why a process ended with an exit ``status``, -n of one that signal n ended."""
    if status >= 0:
        return f"its process ended before it was done (exit status {status})"
    if -status == signal.SIGKILL:
        return f"its process was ended by the system (signal {-status}): too little memory? Use fewer --jobs"
    return f"its process was ended by the system (signal {-status}, {signal.strsignal(-status) or 'unknown'})"
