"""TOML tables read into dataclasses (or the arguments of any function), with every fault of a file collected.

A fault starts with its place, ``dataset.toml: sensors[3].quantity: ...``; list items are numbered from 1. Reading goes
on after a fault, so that a user sees all of them at once.
"""

import inspect
import json
import tomllib
from collections.abc import Callable, Collection, Iterable
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from annotated_types import Interval
from pydantic import ConfigDict, TypeAdapter, ValidationError

from fe_models.errors import InputError
from fe_models.files.size_limit import require_file
from fe_models.value_limits import DEEPEST, DOTTED_KEY, MOST_BYTES, MOST_ITEMS, depth_of, value_fault

T = TypeVar("T")
Table = dict[str, Any]
MAX_VALUE_CHARACTERS = 60
MOST_COMPARED = 100  # known words among which a near one is looked for: it takes a millisecond each
MOST_NAMES = 12  # of those that are known, in a hint
LONGEST_NAME = 60  # characters of a word for which a near one is looked for
TOO_DEEP = f"not valid TOML: nested too deeply, at most {DEEPEST} tables or lists may stand within each other"


def read_toml(path: Path) -> Table:
    """Return the content of a TOML file; `InputError` names the line of a syntax error, or the limit that it breaks."""
    require_file(path)
    size = path.stat().st_size
    if size > MOST_BYTES:
        raise InputError(f"{path}: has {size:.3g} bytes; a file of this kind has at most {MOST_BYTES:.3g}")
    try:
        return parse_toml(path.read_bytes().decode("utf-8-sig"), path.name)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path.name}: not UTF-8 text (byte {error.start}); save it as UTF-8") from None


def parse_toml(text: str, file_name: str) -> Table:
    """Return the content of a TOML document; ``file_name`` is for messages."""
    if DOTTED_KEY.search(text):
        raise InputError(f"{file_name}: {TOO_DEEP}")
    try:
        document = tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{file_name}: {TOO_DEEP}") from None
    except ValueError as error:  # also of an integer of thousands of digits
        raise InputError(f"{file_name}: not valid TOML: {error}") from None
    if depth_of(document) > DEEPEST:
        raise InputError(f"{file_name}: {TOO_DEEP}")
    return document


def read_table(
    make: Callable[..., T],
    table: object,
    where: str,
    faults: list[str],
    required: Collection[str] = (),
) -> T | None:
    """Return ``make(**table)`` with each value checked against the annotation of its parameter.

    ``make`` is a dataclass or a function; its parameters without default, and those named in ``required``, must be
    there. Adds what is wrong to ``faults``, and returns None if it is one of these; else defaults stand in for it, and
    other faults are found as well.
    """
    if not isinstance(table, dict):
        faults.append(f"{where}: expected a table, found {show(table)}")
        return None
    parameters = inspect.signature(make).parameters
    check_keys(table, parameters, where, faults)
    values: Table = {}
    for key, parameter in parameters.items():
        known = len(faults)
        if key in table:
            value = read_value(parameter.annotation, table[key], at(where, key), faults)
            if len(faults) == known:
                values[key] = value
        elif key in required or parameter.default is parameter.empty:
            faults.append(f"{at(where, key)}: missing; expected {describe(parameter.annotation)}")
    needed = {*required, *(key for key, parameter in parameters.items() if parameter.default is parameter.empty)}
    if not needed <= values.keys():
        return None
    try:
        return make(**values)
    except InputError as error:
        faults.extend(f"{where}: {fault}" for fault in error.faults)
        return None


def read_value(annotation: Any, value: object, where: str, faults: list[str]) -> Any:
    """Return ``value`` as ``annotation`` asks (lists as tuples); NaN, infinity, and booleans for numbers are faults."""
    try:
        read = _adapter(annotation).validate_json(json.dumps(value))
    except (ValidationError, TypeError):  # TypeError: TOML dates, which JSON lacks
        faults.append(f"{where}: expected {describe(annotation)}, found {show(value)}")
        return None
    fault = value_fault(value)
    if fault:
        faults.append(f"{where}: {fault}")
        return None
    return read


def read_list(table: Table, key: str, where: str, faults: list[str]) -> list[tuple[str, Any]]:
    """Return the items of the optional list ``table[key]``, each with its place."""
    items = table.get(key, [])
    if not isinstance(items, list):
        faults.append(f"{at(where, key)}: expected a list, found {show(items)}")
        return []
    if len(items) > MOST_ITEMS:
        faults.append(f"{at(where, key)}: has {len(items)} items; at most {MOST_ITEMS} are read")
        return []
    return [(f"{at(where, key)}[{number}]", item) for number, item in enumerate(items, start=1)]


def check_keys(table: Table, known: Iterable[str], where: str, faults: list[str]) -> None:
    """Add a fault for each key of ``table`` that is not ``known``, with the nearest one that is."""
    names = list(known)
    faults.extend(f"{at(where, key)}: unknown key{did_you_mean(key, names)}" for key in table if key not in names)


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "; did you mean ...?" with the nearest known word, or all the known ones where none is near."""
    names = list(known)
    if not names:
        return "; there is none"
    known_words = names if len(names) <= MOST_COMPARED and len(word) <= LONGEST_NAME else []
    near = get_close_matches(word, known_words, n=1)
    if near:
        return f"; did you mean {near[0]!r}?"
    more = f", ... ({len(names)} in all)" if len(names) > MOST_NAMES else ""
    return f"; expected one of {', '.join(names[:MOST_NAMES])}{more}"


def at(where: str, key: str) -> str:
    """Return the place of ``key`` inside ``where``, which is a file ("f.toml:") or a table in it."""
    return f"{where} {key}" if where.endswith(":") else f"{where}.{key}"


def show(value: object) -> str:
    """Return ``value`` for a message, shortened."""
    text = json.dumps(value, default=str, ensure_ascii=False)
    return text if len(text) <= MAX_VALUE_CHARACTERS else text[: MAX_VALUE_CHARACTERS - 3] + "..."


def describe(annotation: Any) -> str:
    """Return an annotation in words: ``tuple[float, ...]`` is "[number, ...]"."""
    arguments = [argument for argument in get_args(annotation) if argument is not NoneType]
    origin = get_origin(annotation)
    if origin is Annotated:
        ranges = [f" from {part.ge:.6g} to {part.le:.6g}" for part in arguments[1:] if isinstance(part, Interval)]
        return describe(arguments[0]) + "".join(ranges)
    if origin in (Union, UnionType):
        return " or ".join(describe(argument) for argument in arguments)
    if origin is Literal:
        return " or ".join(json.dumps(argument) for argument in arguments)
    if origin is tuple:
        return "[" + ", ".join("..." if item is Ellipsis else describe(item) for item in arguments) + "]"
    return {float: "a number", int: "an integer", str: "text", bool: "true or false"}.get(annotation, str(annotation))


@cache
def _adapter(annotation: Any) -> TypeAdapter[Any]:
    # Strict: "4" and true are no numbers. JSON input: its arrays may become tuples all the same.
    return TypeAdapter(annotation, config=ConfigDict(strict=True, allow_inf_nan=False))
