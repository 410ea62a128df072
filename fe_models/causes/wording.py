"""Places in words, and the sentence of a cause."""

from itertools import groupby
from typing import Any

from fe_models.causes.load_name import load_words


def sentence(template: str, location: dict[str, Any], **words: str) -> str:
    """Return a ``template`` with its location, as "place" or "at", and further words filled in, as a sentence."""
    text = template.format(place=place_words(location), at=at_place(location), **words)
    return text[0].upper() + text[1:] + "."


def kind_words(kind: str) -> str:
    """Return a kind of cause in words: "cubic spring", "Coulomb friction"."""
    return kind.replace("_", " ").replace("coulomb", "Coulomb")


def place_words(location: dict[str, Any]) -> str:
    """Return a location in words."""
    if "sensor" in location:
        return f"sensor {location['sensor']}"
    if "load" in location:
        return load_words(location["load"])
    if "element" in location:
        return f"element {location['element']}"
    if "group" in location:
        return f"group {location['group']!r}"
    if "elements" in location:
        one = len(location["elements"]) == 1
        return f"element {location['elements'][0]}" if one else f"each of elements {_runs(location['elements'])}"
    if "modes" in location:
        return "mode " + ", ".join(str(mode) for mode in location["modes"])
    if "nodes" in location:
        return f"nodes {location['nodes'][0]} and {location['nodes'][1]} in {location['direction']}"
    if "direction" in location:
        return f"node {location['node']} in {location['direction']}"
    return f"node {location['node']}" if "node" in location else "the whole model"


def _runs(numbers: list[int]) -> str:
    """Return numbers in words, those that follow one another as "1 to 4"."""
    groups = groupby(enumerate(sorted(numbers)), key=lambda item: item[1] - item[0])  # constant along a run
    runs = [[number for _, number in group] for _, group in groups]
    words = [f"{run[0]} to {run[-1]}" if len(run) > 1 else str(run[0]) for run in runs]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def at_place(location: dict[str, Any]) -> str:
    """Return where something acts, in words: at a place, between two nodes, in the whole model."""
    preposition = "between" if "nodes" in location else "at" if location else "in"
    return f"{preposition} {place_words(location)}"
