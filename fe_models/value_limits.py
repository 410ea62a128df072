"""How large numbers, how long texts and how deep tables of a file may be: what lies beyond is refused when it is read.

All that is computed multiplies and divides a few of these numbers, and stays within a floating-point number's range.
"""

import re
from math import isfinite
from typing import Any
from unicodedata import category

from fe_models.errors import printable

LARGEST = 1e30  # in SI units: products of five such numbers have a square
LARGEST_INTEGER = 2**53  # up to which every integer is a floating-point number
LONGEST_TEXT = 1000  # characters of a name or a path
MOST_ITEMS = 100_000  # of a list
DEEPEST = 20  # tables and lists within each other
MOST_BYTES = 2**24  # of a TOML file: a structure of 100,000 nodes and elements has half of that
DOTTED_KEY = re.compile(rf"""(?<![\w\-."'])(?:[\w\-"']+[ \t]*\.[ \t]*){{{DEEPEST}}}""")
"""A key of many parts, for which a reader of TOML takes time that grows with their square."""


def number_fault(number: float) -> str:
    """Return what is wrong with a number, nothing where it can be used."""
    if isinstance(number, int):
        return "" if abs(number) <= LARGEST_INTEGER else f"is an integer beyond {LARGEST_INTEGER}, the largest"
    if not isfinite(number):
        return f"is {number}; expected a finite number"
    return "" if abs(number) <= LARGEST else f"is {number:g}; numbers are at most {LARGEST:g} in size"


def text_fault(text: str) -> str:
    """Return what is wrong with a name or a path, nothing where it can be used."""
    if len(text) > LONGEST_TEXT:
        return f"has {len(text)} characters; at most {LONGEST_TEXT} are read"
    if not text.isprintable() and any(category(character) == "Cc" for character in text):
        return f"holds a control character ({printable(text, 60)!r}); leave it out"
    return ""


def value_fault(value: Any) -> str:
    """Return what is wrong with the first number or text of a plain value, of lists in it, too."""
    if isinstance(value, bool):
        return ""
    if isinstance(value, int | float):
        return number_fault(value)
    if isinstance(value, str):
        return text_fault(value)
    if isinstance(value, list | tuple):
        if len(value) > MOST_ITEMS:
            return f"has {len(value)} items; at most {MOST_ITEMS} are read"
        return next((fault for fault in map(value_fault, value) if fault), "")
    return ""


def depth_of(document: Any) -> int:
    """Return how many tables and lists stand within each other, at most one more than `DEEPEST`."""
    level, depth = [document], 0
    while level and depth <= DEEPEST:
        level = [item for each in level for item in _items(each)]
        depth += 1
    return depth


def _items(value: Any) -> list[Any]:
    items = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return [item for item in items if isinstance(item, dict | list)]
