"""Name what a simulation gets wrong: the same as `hybrid-modal diagnose`."""

from hybrid.commands.console import standalone
from hybrid.commands.diagnose import diagnose

app = standalone(diagnose)

if __name__ == "__main__":
    app()
