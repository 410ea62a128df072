"""What all commands share: how their applications are set up."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from fe_models.recordings import Dataset


def new_app(completion: bool = False, help: str | None = None) -> typer.Typer:
    """Return an application with plain help: the richer one reads ":x:" in an example as the name of a picture."""
    return typer.Typer(
        help=help,
        add_completion=completion,
        no_args_is_help=True,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
    )


def standalone(command: Callable[..., None]) -> typer.Typer:
    """Return an application of one ``command`` alone, for the scripts."""
    app = new_app()
    app.command()(command)
    return app


def print_notes(dataset: "Dataset") -> None:
    """Say what a user should know of how a dataset's files were read."""
    for note in dataset.notes:
        print(f"Note: {note}.")
