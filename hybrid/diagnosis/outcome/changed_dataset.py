"""What would be explained if something that a dataset says, and that is no cause on the list, were otherwise."""

from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.outcome.config import MENTION


def taken_away(found: Fit | None, item: Fit) -> str | None:
    """Return in words how much of what ``item`` leaves a fit to the changed dataset takes away; None where little."""
    if found is None or found.misfit > MENTION.max_left_of_changed * item.misfit:
        return None
    share = 1 - max(found.misfit, 0.0) / item.misfit
    return f"would take {share:.0%} of what the model leaves beyond noise away"
