"""What the rates of blind cases are to be: by what moves the structure, how near its drawing is to the truth, and where
the hidden cause acts.
"""

from dataclasses import dataclass, replace

from benchmarks.blind_cases import Acts, Excitation, Tier

OVER_FLOOR = {"exact": 1.05, "off": 1.15, "far": 1.15}  # extended forecast over noise floor


@dataclass(frozen=True)
class Aims:
    """The aim of each rate, in words; "" where there is none."""

    first: str
    listed: str
    pairs: str
    wrong: str
    clean: str
    outside: str
    parameters: str
    groups: str = ""  # that are far from their drawing


EXACT = Aims(">= 99 %", "100 %", ">= 90 %", "0", "<= 1 %", ">= 98 %", ">= 98 %")
OFF = Aims(">= 95 %", ">= 99 %", ">= 80 %", "<= 1 %", "<= 2 %", ">= 95 %", ">= 95 %")
FAR = Aims(">= 75 %", ">= 90 %", "", "<= 2 %", "", "", "", "90-98 %")
AIMS: dict[tuple[Tier, Acts], Aims] = {
    ("exact", "all"): EXACT,
    ("off", "all"): OFF,
    ("far", "all"): FAR,
    ("exact", "one"): replace(EXACT, first=">= 98 %"),
    ("off", "one"): OFF,
    ("far", "one"): replace(FAR, first=">= 90 %", listed=">= 97 %", wrong="<= 1 %"),
}
AMBIENT = Aims("", ">= 90 %", "", "<= 2 %", "<= 2 %", "", "")
ON_A_BASE = Aims(">= 95 %", "", "", "<= 2 %", "<= 2 %", ">= 95 %", ">= 95 %")


def aims_of(tier: Tier, acts: Acts, excitation: Excitation) -> Aims:
    """Return what is to be reached in such cases."""
    match excitation:
        case "ambient":
            return replace(AMBIENT, first=">= 80 %") if acts == "one" else AMBIENT
        case "base":
            return ON_A_BASE
    return AIMS[tier, acts]
