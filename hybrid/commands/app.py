"""The command `hybrid-modal` with its sub-commands."""

from typing import Annotated

import typer

from hybrid.commands import benchmark
from hybrid.commands.build import build
from hybrid.commands.compare import compare
from hybrid.commands.console import new_app
from hybrid.commands.diagnose import diagnose
from hybrid.commands.inspect import inspect
from hybrid.commands.predict import predict
from hybrid.commands.render import render
from hybrid.commands.simulate import simulate
from hybrid.commands.train import train
from hybrid.commands.watch import watch

COMMANDS = (build, simulate, train, predict, render, diagnose, watch, compare, inspect)


def _show_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"hybrid-modal {version('hybrid-modal')}")
        raise typer.Exit


def _main(
    show_version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version, and exit.")
    ] = False,
) -> None:
    """Take the options that stand before a sub-command."""


def main_app() -> typer.Typer:
    """Return the command with all its sub-commands, those of other distributions among them."""
    app = new_app(
        completion=True,
        help="""Finite element models that learn from a few sensors, and say what a simulation gets wrong.

        \b
        hybrid-modal build frame.toml --out runs/frame
        hybrid-modal simulate frame.toml --out runs/data --pull 3:x:100 --sensor 2:x
        hybrid-modal diagnose runs/data/dataset.toml --out runs/diagnosis
        """,
    )
    app.callback()(_main)
    for command in COMMANDS:
        app.command()(command)
    app.command("benchmark")(benchmark.command())
    return app


app = main_app()
