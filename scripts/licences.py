"""The licences of all that the program needs to run: name, version, licence, a line each.

python scripts/licences.py        what 'pip install .' brings
python scripts/licences.py dev    ... and what the extra "dev" adds (fleet, docs)

They are what the packages say of themselves. A package that says nothing is listed as "not stated", and the exit
status is then 1.
"""

import sys
from importlib.metadata import Distribution, PackageNotFoundError, distribution

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PROJECT = "hybrid-modal"
NOT_STATED = "not stated"
LONGEST = 80  # characters: some packages put the whole text where its name belongs
CLASSIFIER = "License :: OSI Approved :: "


def needed(name: str, extras: frozenset[str] = frozenset()) -> dict[str, Distribution]:
    """Return the distributions that one with ``extras`` needs on this machine, itself among them, by name."""
    found = dict[str, Distribution]()
    waiting, seen = [(name, extras)], set[tuple[str, frozenset[str]]]()
    while waiting:
        item = waiting.pop()
        if item in seen:
            continue
        seen.add(item)
        own = distribution(item[0])
        found[canonicalize_name(item[0])] = own
        for requirement in map(Requirement, own.requires or ()):
            marker = requirement.marker
            if marker is None or any(marker.evaluate({"extra": extra}) for extra in {"", *item[1]}):
                waiting.append((requirement.name, frozenset(requirement.extras)))
    return found


def licence_of(own: Distribution) -> str:
    """Return a distribution's licence in its own words, the shortest place first that has some."""
    classified = [
        words.removeprefix(CLASSIFIER) for words in _fields(own, "Classifier") if words.startswith(CLASSIFIER)
    ]
    for words in (*_fields(own, "License-Expression"), " and ".join(classified), *_fields(own, "License")):
        first = words.strip().split("\n")[0].strip()
        if first and first.upper() != "UNKNOWN":
            return first if len(first) <= LONGEST else f"{first[: LONGEST - 3]}..."
    return NOT_STATED


def _fields(own: Distribution, name: str) -> list[str]:
    return own.metadata.get_all(name) or []


def main(extras: list[str]) -> int:
    """Print the licences; return the exit status."""
    try:
        found = needed(PROJECT, frozenset(extras))
    except PackageNotFoundError as error:
        print(f"error: {error.name} is not installed; run 'make setup' first", file=sys.stderr)
        return 2
    rows = [(name, own.version, licence_of(own)) for name, own in sorted(found.items())]
    widths = [max(len(row[column]) for row in rows) for column in (0, 1)]
    print(*(f"{name:{widths[0]}}  {version:{widths[1]}}  {licence}" for name, version, licence in rows), sep="\n")
    return 1 if any(licence == NOT_STATED for _, _, licence in rows) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
