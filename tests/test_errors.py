"""Messages about bad input: bounded and in printable characters, whatever they quote."""

import pytest

from fe_models.errors import LEFT_OUT, MOST_CHARACTERS, MOST_FAULTS, InputError, printable


@pytest.mark.parametrize("quoted", ["x" * 10**6, "\x00" * 10**6, "\x1b[2J" * 500, "\u202e" * (MOST_CHARACTERS - 1)])
def test_a_message_is_bounded_and_printable_whatever_it_quotes(quoted: str) -> None:
    shown = printable(f"odd.toml: unknown name {quoted!r}; expected nodes" if "x" in quoted else quoted)
    assert len(shown) == MOST_CHARACTERS
    assert LEFT_OUT in shown
    assert shown.isprintable()


def test_a_short_message_is_as_it_was_written() -> None:
    assert printable("nodes: é has no place") == "nodes: é has no place"


def test_of_many_faults_the_first_are_listed_and_the_others_counted() -> None:
    error = InputError(f"fault {number}" for number in range(MOST_FAULTS + 7))
    assert error.faults[0] == "fault 0"
    assert len(error.faults) == MOST_FAULTS + 1
    assert "7 more" in error.faults[-1]
