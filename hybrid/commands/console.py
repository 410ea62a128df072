"""What all commands share: how their applications are set up."""

from collections.abc import Callable

import typer


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
