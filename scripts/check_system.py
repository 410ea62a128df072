"""Check, before anything is installed, that this machine can run the product; say what is missing and how to get it."""

import ctypes
import sys

OLDEST, NEWEST = (3, 11), (3, 13)
LIBRARIES = {  # shared library: (who needs it, Debian package)
    "libGL.so.1": ("Exudyn and VTK", "libgl1"),
    "libEGL.so.1": ("VTK, to draw without a screen", "libegl1"),
}


def faults() -> list[str]:
    """Return one line for each thing that is missing."""
    found = []
    if not OLDEST <= sys.version_info[:2] <= NEWEST:
        found.append(
            f"Python {sys.version_info[0]}.{sys.version_info[1]} is not supported: use 3.11, 3.12 or 3.13,"
            " for example 'make PYTHON=python3.11 demo'."
        )
    for library, (user, package) in LIBRARIES.items():
        try:
            ctypes.CDLL(library)
        except OSError:
            found.append(
                f"The system library {library} is missing ({user} needs it)."
                f" On Debian or Ubuntu: apt-get install {package}"
            )
    return found


if __name__ == "__main__":
    lines = faults()
    print(*lines, sep="\n", file=sys.stderr)
    sys.exit(2 if lines else 0)
