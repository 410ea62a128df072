"""Options that a dataclass groups: each is one of the command's own, and the command gets them as one."""

from dataclasses import dataclass
from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from hybrid.commands.console import standalone
from hybrid.commands.option_groups import with_option_groups


@dataclass(frozen=True)
class Springs:
    count: Annotated[int, typer.Option(min=1, help="How many.")] = 2
    stiffness: Annotated[float | None, typer.Option(help="N/m.")] = None


SPRINGS = Springs()
seen: list[tuple[str, Springs, bool]] = []


@with_option_groups
def build(
    name: Annotated[str, typer.Argument()],
    springs: Springs = SPRINGS,
    loud: Annotated[bool, typer.Option("--loud")] = False,
) -> None:
    """Build a chain."""
    seen.append((name, springs, loud))


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ([], (SPRINGS, False)),
        (["--stiffness", "3.5", "--loud"], (Springs(2, 3.5), True)),
        (["--count", "4"], (Springs(4), False)),
    ],
)
def test_a_command_gets_its_groups_whole(options: list[str], expected: tuple[Springs, bool]) -> None:
    result = CliRunner().invoke(standalone(build), ["chain", *options])
    assert result.exit_code == 0, result.output
    assert seen.pop() == ("chain", *expected)


def test_the_limits_of_grouped_options_hold() -> None:
    result = CliRunner().invoke(standalone(build), ["chain", "--count", "0"])
    assert result.exit_code == 2
    assert not seen


def test_help_names_grouped_options_in_their_place() -> None:
    answer = CliRunner().invoke(standalone(build), ["--help"]).output
    assert "Build a chain." in answer
    places = [answer.index(word) for word in ("--count", "--stiffness", "--loud")]
    assert places == sorted(places)
    assert "--springs" not in answer
