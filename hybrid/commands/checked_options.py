"""Options of all commands, checked before any begins: numbers to compute with, texts to print, names of files."""

import os
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperCommand

from fe_models.errors import bad_input_exits, raise_faults
from fe_models.value_limits import value_fault

LONGEST_NAME = 255  # bytes of a file's or folder's name, on all usual file systems


class CheckedCommand(TyperCommand):
    """A command that refuses odd values of its options, all at once."""

    def invoke(self, context: Any) -> Any:
        """Run the command."""
        with bad_input_exits():
            raise_faults(
                f"{parameter.opts[0] if parameter.opts[0].startswith('-') else parameter.name} {fault}"
                for parameter in self.params
                if (fault := _fault(context.params.get(parameter.name or "")))
            )
        return super().invoke(context)


class CheckedApplication(typer.Typer):
    """An application whose commands are checked so."""

    def command(self, name: str | None = None, **settings: Any) -> Any:
        """Return what makes a command of a function."""
        return super().command(name, **{"cls": CheckedCommand, **settings})


def _fault(value: Any) -> str:
    if isinstance(value, list | tuple):
        return next((fault for fault in map(_fault, value) if fault), "")
    if not isinstance(value, Path):
        return value_fault(value)
    longest = max((len(os.fsencode(part)) for part in value.parts), default=0)
    too_long = f"has a name of {longest} bytes; file systems take {LONGEST_NAME}" if longest > LONGEST_NAME else ""
    return value_fault(str(value)) or too_long
