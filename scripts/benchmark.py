"""Measure the product against its peers: the same as `hybrid-modal benchmark`."""

from benchmarks.command import benchmark
from hybrid.commands.console import standalone

app = standalone(benchmark)

if __name__ == "__main__":
    app()
