"""Compare recordings with the model's modes and with one another: the same as `hybrid-modal compare`."""

from hybrid.commands.compare import compare
from hybrid.commands.console import standalone

app = standalone(compare)

if __name__ == "__main__":
    app()
