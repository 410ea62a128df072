"""Inputs that nobody would write on purpose, made by a generator from inputs that are right.

A document loses parts, has some twice, others in lists or out of them, and odd values in place of good ones; bytes of a
file are turned, cut off or doubled. What reads them must return something, or raise an `InputError` that is fit to
print.
"""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import deepcopy
from datetime import date
from types import FrameType
from typing import Any

from hypothesis import strategies as st

from fe_models.errors import MOST_CHARACTERS, MOST_FAULTS, InputError

LONGEST = 10  # s of a core, for any input
WAITING = 20  # times as long, on a machine that others use, too: what waits for a pipe, say, works for nothing

NUMBERS: list[Any] = [
    0, -1, 1, 2, 7, 10**6, 10**9, 10**18, 2**63, -(2**63), 10**400, 0.0, -0.0, -1.0, 0.5, 1e-300, 5e-324, 1e-200, 1e-30,
    1e-12, 1e12, 1e30, 1e200, 1e300, -1e300, float("nan"), float("inf"), -float("inf"),
]  # fmt: skip
TEXTS: list[Any] = [
    "", " ", "x", "y", "rz", "z", "node", "é", "x" * 5000, "\x1b[31mred", "a\x00b", "\u202eabc", "$\\frac{", "$x_$",
    "..", "/dev/zero", "/proc/self/mem", "none.toml", "a" * 300 + ".npz", "1e5", "nan", "true", "measured", "test",
    "ambient",
]  # fmt: skip
OTHERS: list[Any] = [True, False, [], {}, [[]], [{}], {"a": {}}, [1, "a"], [1.0] * 3, {"name": "x"}, date(2020, 1, 1)]


INSERTED = [b"\xef\xbb\xbf", b"\0", b"\x1b[2J", b"nan", b"1e999", b",,", b"\n"]


def odd_values(more: list[Any] | None = None) -> st.SearchStrategy[Any]:
    """Values that do not belong where they are put; ``more``: those of a special kind."""
    plain = st.sampled_from([*NUMBERS, *TEXTS, *OTHERS, *(more or [])])
    return st.one_of(plain, st.floats(), st.integers(), st.text(max_size=20), st.lists(plain, max_size=3))


@st.composite
def changed(draw: st.DrawFn, document: Any, values: st.SearchStrategy[Any]) -> Any:
    """A copy of a document of tables and lists with one to three of its parts changed."""
    found = deepcopy(document)
    for _ in range(draw(st.integers(1, 3))):
        _change(draw, found, values)
    return found


def _change(draw: st.DrawFn, document: Any, values: st.SearchStrategy[Any]) -> None:
    container = document
    while True:
        keys = list(container) if isinstance(container, dict) else list(range(len(container)))
        if not keys:
            return
        key = draw(st.sampled_from(keys))
        deeper = isinstance(container[key], dict | list) and len(container[key]) > 0
        if not deeper or draw(st.integers(0, 3)) == 0:
            break
        container = container[key]
    value = container[key]
    kind = draw(st.sampled_from(["replace", "replace", "replace", "delete", "double", "wrap", "unwrap", "unknown"]))
    if kind == "replace":
        container[key] = draw(values)
    elif kind == "delete":
        del container[key]
    elif kind == "double" and isinstance(container, list):
        container.insert(key, deepcopy(value))
    elif kind == "wrap":
        container[key] = [value]
    elif kind == "unwrap" and isinstance(value, list) and value:
        container[key] = value[0]
    elif isinstance(container, dict):
        container[draw(st.sampled_from(["unknown", "", "x" * 3000, "\x1b]0;title\x07", "nodes", "file"]))] = value


@st.composite
def damaged(draw: st.DrawFn, content: bytes) -> bytes:
    """The bytes of a file with some of them turned, left out, cut off or doubled."""
    found = bytearray(content)
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, max(len(found) - 1, 0)))
        kind = draw(st.sampled_from(["turn", "turn", "set", "cut", "drop", "double", "insert"]))
        if kind == "turn" and found:
            found[place] ^= 1 << draw(st.integers(0, 7))
        elif kind == "set":
            found[place : place + 4] = draw(st.sampled_from([b"\xff\xff\xff\xff", b"\0\0\0\0", b"\x7f\xff\xff\xff"]))
        elif kind == "cut":
            del found[place:]
        elif kind == "drop":
            del found[place : place + draw(st.integers(1, 64))]
        elif kind == "double":
            found[place:place] = found[place : place + 64]
        else:
            found[place:place] = draw(st.sampled_from(INSERTED))
    return bytes(found)


class TooLongError(AssertionError):
    """An input took too long; no error of an input or a machine, which commands would answer."""


@contextmanager
def within(seconds: int = LONGEST) -> Iterator[None]:
    """Raise `TooLongError` where the block computes for longer, or waits for `WAITING` times as long."""

    def late(number: int, frame: FrameType | None) -> None:
        raise TooLongError(f"an input took more than {seconds} s")

    timers = {signal.SIGPROF: (signal.ITIMER_PROF, seconds), signal.SIGALRM: (signal.ITIMER_REAL, WAITING * seconds)}
    before = {number: signal.signal(number, late) for number in timers}
    for timer, limit in timers.values():
        signal.setitimer(timer, limit)
    try:
        yield
    finally:
        for timer, _ in timers.values():
            signal.setitimer(timer, 0)
        for number, handler in before.items():
            signal.signal(number, handler)


def answered(read: Callable[[], object]) -> bool:
    """Whether an input could be used; where not, its faults are few, short and free of control codes."""
    try:
        with within():
            read()
    except InputError as error:
        assert 1 <= len(error.faults) <= MOST_FAULTS + 1
        for fault in error.faults:
            assert len(fault) <= 2 * MOST_CHARACTERS
            assert not any(ord(character) < 32 or 127 <= ord(character) < 160 for character in fault), repr(fault)
        return False
    return True
