"""TOML as an engineer would lay it out: one node, element or sensor a line."""

from typing import Any

import numpy as np
import tomli_w


def toml_text(document: dict[str, Any]) -> str:
    """Return ``document`` (its keys bare words) as TOML, tables last; floats keep all their digits."""
    values = {key: value for key, value in document.items() if not isinstance(value, dict)}
    tables = {key: value for key, value in document.items() if isinstance(value, dict)}
    lines = [f"{key} = {_lines(value)}" for key, value in values.items()]
    for name, table in tables.items():
        lines += ["", f"[{name}]", *(f"{key} = {_inline(value)}" for key, value in table.items())]
    return "\n".join(lines) + "\n"


def _lines(value: Any) -> str:
    """Return a value, a list of lists or tables with one item a line."""
    if isinstance(value, list) and any(isinstance(item, list | dict) for item in value):
        return "\n".join(["[", *(f"    {_inline(item)}," for item in value), "]"])
    return _inline(value)


def _inline(value: Any) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_inline(item) for item in value) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_inline(item)}" for key, item in value.items()) + " }"
    value = value.item() if isinstance(value, np.generic) else value
    return tomli_w.dumps({"value": value}).removeprefix("value = ").removesuffix("\n")
