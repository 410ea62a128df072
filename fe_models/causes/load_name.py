"""What a known load is called in reports."""

from typing import Any, Literal

from fe_models.structure import Direction

LoadName = tuple[int, Direction] | Literal["base", "all"]
"""The node and direction of a load; "base": the motion of the base; "all": all that is known to act."""


def load_words(load: Any) -> str:
    """Return which recorded load a location means, in words."""
    if load == "base":
        return "the recorded motion of the base"
    if load == "all":
        return "each of the recorded loads"
    node, direction = load
    return f"the recorded load at node {node} in {direction}"
