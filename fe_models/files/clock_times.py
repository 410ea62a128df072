"""Times of a clock, as loggers write them beside samples: a date with a time, or a time of day alone."""

from datetime import datetime, time

BEGIN = datetime(1970, 1, 1)
FORMATS = ("%d.%m.%Y %H:%M:%S.%f", "%d.%m.%Y %H:%M:%S", "%m/%d/%Y %H:%M:%S.%f", "%m/%d/%Y %H:%M:%S")
"""Beside those of ISO 8601."""


def clock_seconds(cell: str) -> float:
    """Return a time of a clock in s, from 1970 or from midnight; `ValueError` where the cell holds none.

    Time zones are left out: samples of one file have one.
    """
    text = cell.strip().replace(",", ".")
    try:
        return _since(datetime.fromisoformat(text))
    except ValueError:
        pass
    try:
        return _since(datetime.combine(BEGIN, time.fromisoformat(text)))
    except ValueError:
        pass
    for form in FORMATS:
        try:
            return _since(datetime.strptime(text, form))
        except ValueError:
            continue
    raise ValueError(f"{cell!r} is no time of a clock")


def _since(moment: datetime) -> float:
    return (moment.replace(tzinfo=None) - BEGIN).total_seconds()
