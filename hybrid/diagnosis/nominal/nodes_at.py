"""Which nodes a place of a structure touches."""

from typing import Any

from fe_models.structure import Structure


def nodes_at(place: dict[str, Any], structure: Structure) -> set[int]:
    """Return the nodes of a place that is one node, two of them, or one element; none of others."""
    elements = [place["element"]] if "element" in place else place.get("elements", [])
    if len(elements) == 1:
        return set(structure.elements[elements[0] - 1].nodes)
    return {place["node"]} if "node" in place else set(place.get("nodes", ()))
