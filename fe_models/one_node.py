"""A place at one node, as files write it: ``node=1`` for ``nodes=(1,)``, with the ground at the other end."""

from functools import wraps
from typing import Any, TypeVar

Placed = TypeVar("Placed")


def node_or_nodes(cls: type[Placed]) -> type[Placed]:
    """Let a dataclass with ``nodes`` be made with ``node``, too. Type checkers know ``nodes`` alone."""
    made_with_nodes = cls.__init__

    @wraps(made_with_nodes)
    def __init__(self: Any, *values: Any, node: int | None = None, **named: Any) -> None:  # noqa: N807
        if node is not None:
            if "nodes" in named:
                raise TypeError(f"{cls.__name__}: give node or nodes, not both")
            named["nodes"] = (node,)
        made_with_nodes(self, *values, **named)

    cls.__init__ = __init__  # type: ignore[method-assign]
    return cls
