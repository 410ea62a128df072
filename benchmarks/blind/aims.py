"""What the rates of blind cases are to be, by how near the drawing is to the truth and where the hidden cause acts."""

from dataclasses import dataclass, replace

from benchmarks.blind_cases.case import Acts, Tier

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


EXACT = Aims(">= 99 %", "100 %", ">= 90 %", "0", "<= 1 %", ">= 98 %", ">= 98 %")
OFF = Aims(">= 95 %", ">= 99 %", ">= 80 %", "<= 1 %", "<= 2 %", ">= 95 %", ">= 95 %")
FAR = Aims(">= 75 %", ">= 90 %", "", "<= 2 %", "", "", "")
AIMS: dict[tuple[Tier, Acts], Aims] = {
    ("exact", "all"): EXACT,
    ("off", "all"): OFF,
    ("far", "all"): FAR,
    ("exact", "one"): replace(EXACT, first=">= 98 %"),
    ("off", "one"): OFF,
    ("far", "one"): replace(FAR, first=">= 90 %", listed=">= 97 %", wrong="<= 1 %"),
}
