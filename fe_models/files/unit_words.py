"""Units as recording files write them: in a row below the names, in brackets behind a name, as a property."""

import re
from dataclasses import dataclass
from math import pi

from fe_models.files.recording_checks import STANDARD_ACCELERATION

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254, "ft": 0.3048}
RADIANS = {"rad": 1.0, "mrad": 1e-3, "deg": pi / 180}
NEWTONS = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "MN": 1e6, "lbf": 4.4482216152605}
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0}
FACTORS: dict[str, tuple[float, str]] = {
    **{word: (factor, "m") for word, factor in METRES.items()},
    **{f"{word}/s": (factor, "m/s") for word, factor in METRES.items()},
    **{f"{word}/s^2": (factor, "m/s^2") for word, factor in METRES.items()},
    **{word: (factor, "rad") for word, factor in RADIANS.items()},
    **{f"{word}/s": (factor, "rad/s") for word, factor in RADIANS.items()},
    **{f"{word}/s^2": (factor, "rad/s^2") for word, factor in RADIANS.items()},
    **{word: (factor, "N") for word, factor in NEWTONS.items()},
    **{f"{word} m": (factor, "N m") for word, factor in NEWTONS.items()},
    **{word: (factor, "s") for word, factor in SECONDS.items()},
    "g": (STANDARD_ACCELERATION, "m/s^2"),
    "mg": (1e-3 * STANDARD_ACCELERATION, "m/s^2"),
    "gal": (1e-2, "m/s^2"),
}
"""What one of each unit is in SI, and that SI unit."""

SAME = {"µ": "u", "μ": "u", "°": "deg", "²": "^2", "**": "^", "·": " ", "⋅": " ", "*": " ", "sec": "s", "/s/s": "/s^2"}
OTHERS = {"gn": "g", "g_n": "g", "Nm": "N m", "kNm": "kN m", "MNm": "MN m", "seconds": "s"}
BRACKETS = re.compile(r"^(?P<name>.*\S)\s*[\[(](?P<unit>[^\[\]()]+)[\])]$")


@dataclass(frozen=True)
class Unit:
    """A unit: one of it is ``factor`` of the unit ``si``."""

    factor: float
    si: str


def known_unit(text: str) -> Unit | None:
    """Return the unit that ``text`` is, however it is written ("m/s²", "[M/S2]", "m/sec^2"); None for other words."""
    word = text.strip().strip("[]() ")
    found = FACTORS.get(_as_written_here(word))
    if found is None and word.isupper():  # "MM/S2": capitals throughout say nothing of prefixes
        found = FACTORS.get(_as_written_here(word.lower()))
    return None if found is None else Unit(*found)


def _as_written_here(word: str) -> str:
    for old, new in SAME.items():
        word = word.replace(old, new)
    word = re.sub(r"/s2$", "/s^2", re.sub(r"\s+", " ", word))
    return OTHERS.get(word, word)


def name_and_unit(header: str) -> tuple[str, str]:
    """Return a column's name and the unit in brackets behind it: "A1 [g]" is A1 in g; "" where there is none."""
    match = BRACKETS.match(header.strip())
    if match is None or known_unit(match["unit"]) is None:
        return header.strip(), ""
    return match["name"], match["unit"].strip()
