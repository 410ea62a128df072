"""Draw the deformed shapes of a run: the same as `hybrid-modal render`."""

from hybrid.commands.console import standalone
from hybrid.commands.render import render

app = standalone(render)

if __name__ == "__main__":
    app()
