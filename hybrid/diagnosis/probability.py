"""Probabilities as people read them, never as certain."""

SUREST = 0.999  # no probability is said to be more


def two_decimals(probability: float) -> str:
    """Return a probability to two decimals, for a terminal: "0.97", or "> 0.99" where that would be rounded to one."""
    text = f"{probability:.2f}"
    return {"1.00": "> 0.99", "0.00": "< 0.01"}.get(text, text)


def per_cent(probability: float) -> str:
    """Return a probability in per cent, for a page: "97 %", or "more than 99.9 %"."""
    if probability > SUREST:
        return "more than 99.9 %"
    if probability < 1 - SUREST:
        return "less than 0.1 %"
    return f"{100 * probability:.{1 if probability > 0.99 or probability < 0.01 else 0}f} %"
