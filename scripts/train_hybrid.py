"""Train the hybrid model on a dataset: the same as `hybrid-modal train`."""

from hybrid.commands.console import standalone
from hybrid.commands.train import train

app = standalone(train)

if __name__ == "__main__":
    app()
