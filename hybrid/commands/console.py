"""What all commands share: how their applications are set up, how they end on bad input, and what --quiet leaves.

What belongs to a result is printed on stdout as sentences: "Note: ...", "Warning: ...". What happens to the command is
printed on stderr in a line that begins with a small letter: "note: ", "warning: ", "error: ".
"""

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from fe_models.errors import OutputError, bad_input_exits, printable
from hybrid.commands.checked_options import CheckedApplication
from hybrid.commands.interrupts import WHOLE, interrupts_exit
from hybrid.commands.streams import written_whatever

if TYPE_CHECKING:
    from fe_models.recordings import Dataset


def new_app(completion: bool = False, help: str | None = None) -> typer.Typer:
    """Return an application with plain help: the richer one reads ":x:" in an example as the name of a picture."""
    return CheckedApplication(
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


@contextmanager
def command_line(quiet: bool) -> Iterator[Callable[[Path], None]]:
    """Run what a command does, and give what takes the path of its main result.

    An `InputError` becomes one line a fault on stderr and exit status 2; a full disk, say, one line and status 1. With
    ``quiet`` there are no progress bars, and the path is all that reaches stdout; otherwise the commands say themselves
    where their results are.
    """
    from fe_models.files.run_guard import guarded
    from fe_models.progress import silent  # loads tqdm

    results: list[Path] = []
    with written_whatever(), bad_input_exits(), failures_exit(), interrupts_exit(), guarded() as guard:
        if not quiet:
            yield results.append
        else:
            with Path(os.devnull).open("w") as nowhere, silent(), redirect_stdout(nowhere):
                yield results.append
            print(*results, sep="\n", file=sys.stdout)
        say(f"{path} was changed while this ran; the results are of what it held before" for path in guard.changed())


@contextmanager
def failures_exit() -> Iterator[None]:
    """Turn what the machine refuses inside the block, disk or memory, into one line on stderr and exit status 1."""
    try:
        yield
    except MemoryError:
        raise OutputError(f"this takes more memory than the machine has; {WHOLE}") from None
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        raise OutputError(f"{where}{error.strerror or error}; {WHOLE}") from error


def given_options(context: typer.Context) -> dict[str, Any]:
    """Return the parameters that a user has given, by name; of the others the command has its defaults."""
    sources = ((name, value, context.get_parameter_source(name)) for name, value in context.params.items())
    return {name: value for name, value, source in sources if source is not None and source.name == "COMMANDLINE"}


def print_notes(dataset: "Dataset") -> None:
    """Say what a user should know of how a dataset's files were read."""
    for note in dataset.notes:
        print(f"Note: {printable(note)}.")


def say(notes: Iterable[str]) -> None:
    """Say what could not be made beside the main results."""
    for note in notes:
        print(f"note: {printable(note)}", file=sys.stderr)


def words_of(command: str, dataset: Path, out: Path) -> list[str]:
    """Return the words of a command line that reads a dataset and writes a folder."""
    return ["hybrid-modal", command, str(dataset), "--out", str(out)]
