"""Numbers and texts as a page has them: uncertainties to two digits, units typeset, kinds of causes in words."""

import re
from math import floor, isfinite, log10

from fe_models.causes.base import CAUSES
from fe_models.causes.wording import kind_words
from hybrid.diagnosis.outcome.findings import Parameter
from hybrid.report.page import Cell

NOTHING = "–"
PLUS_MINUS = "\u00a0±\u00a0"  # where no line breaks
PLAIN = (-4, 5)  # powers of ten between which a value is written without one
KIND = re.compile(rf"\b(?:{'|'.join(kind for kind in CAUSES if '_' in kind)})\b")
SIGNS = {"+-": "±", "^2": "²", "^3": "³"}


def typeset(text: str) -> str:
    """Return a text of a report, which terminals show, as a page shows it: signs for letters, kinds in words."""
    for plain, sign in SIGNS.items():
        text = text.replace(plain, sign)
    return KIND.sub(lambda found: kind_words(found[0]), text)


def sentence(text: str) -> str:
    """Return a note as a sentence."""
    text = typeset(text.strip())
    return text[:1].upper() + text[1:] + ("" if text.endswith((".", "!", "?", ":")) else ".")


def measured(value: float, error: float, unit: str = "") -> str:
    """Return a value with its standard deviation to two digits, and its ``unit``: "0.4999 ± 0.0017 N/m³".

    Without an error (zero, or not finite) four digits of the value.
    """
    ending = typeset(f" {unit}") if unit not in ("", "1") else ""
    if not isfinite(value):
        return NOTHING
    size = max(abs(value), error if isfinite(error) else 0.0)
    power = floor(log10(size)) if size > 0 else 0
    power = 0 if PLAIN[0] <= power < PLAIN[1] else 3 * (power // 3)
    scale = 10.0**power
    times = "" if power == 0 else f" × 10{superscript(power)}"
    if not (isfinite(error) and error > 0):
        return f"{value / scale:.4g}{times}{ending}"
    decimals = max(0, 1 - floor(log10(float(f"{error / scale:.1e}"))))
    both = f"{value / scale:.{decimals}f}{PLUS_MINUS}{error / scale:.{decimals}f}"
    return f"({both}){times}{ending}" if times else f"{both}{ending}"


def superscript(power: int) -> str:
    """Return an exponent in raised digits."""
    return str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def of_parameter(item: Parameter) -> str:
    """Return a parameter of a cause with its uncertainty."""
    return measured(item.value, item.std, item.unit)


def percentage(value: float) -> str:
    """Return a share in per cent, to two digits."""
    if 0 <= value < 5e-4:
        return "less than 0.1 %"
    return f"{100 * value:.2g} %" if value < 0.1 else f"{100 * value:.0f} %"


def share(value: float | None) -> Cell:
    """Return a share in per cent, as a cell."""
    return Cell(NOTHING) if value is None or not isfinite(value) else Cell(percentage(value), float(value))


def number(value: float | None, digits: int = 4) -> Cell:
    """Return a number to so many digits, as a cell."""
    return Cell(NOTHING) if value is None or not isfinite(value) else Cell(f"{value:.{digits}g}", float(value))


def fixed(value: float | None, decimals: int) -> Cell:
    """Return a number with so many decimals, as a cell."""
    return Cell(NOTHING) if value is None or not isfinite(value) else Cell(f"{value:.{decimals}f}", float(value))


def off(value: float | None, from_: float) -> str:
    """Return a value in Hz and by how much it is off another one."""
    return NOTHING if value is None else f"{value:.4g} ({change(value, from_, 1)})"


def change(value: float, from_: float, decimals: int = 2) -> str:
    """Return by how much a value is off another one, in per cent."""
    return f"{100 * (value / from_ - 1):+z.{decimals}f} %"
