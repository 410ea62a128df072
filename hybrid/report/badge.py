"""How often answers like one were right in the certificate, as a badge beside the answer."""

from hybrid.diagnosis.track_record.trust import NOT_YOURS, Trust, percent
from hybrid.report.page import Badge
from hybrid.report.values import sentence

TITLE = "Right in the certificate"
NOTHING_KNOWN = "not known yet"


def badge_of(trust: Trust) -> Badge:
    """Return the badge of an answer."""
    source, right = sentence(trust.source), trust.right
    if right is None:
        return Badge(TITLE, NOTHING_KNOWN, "", f"{trust.sentence}.", source)
    rate, interval = f"{right.hits} of {right.count}", f"95 % interval: {percent(right)}"
    return Badge(TITLE, rate, interval, f"{trust.sentence}. {NOT_YOURS}", source)
