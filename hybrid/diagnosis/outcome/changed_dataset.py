"""What would be explained if something that a dataset says, and that is no cause on the list, were otherwise."""

from hybrid.diagnosis.fitting.least_squares import Fit

LEAVES = 0.1  # of what the model leaves beyond noise: the most that a fit to the changed dataset may leave


def taken_away(found: Fit | None, item: Fit) -> str | None:
    """Return in words how much of what ``item`` leaves a fit to the changed dataset takes away; None where little."""
    if found is None or found.misfit > LEAVES * item.misfit:
        return None
    share = 1 - max(found.misfit, 0.0) / item.misfit
    return f"would take {share:.0%} of what the model leaves beyond noise away"
