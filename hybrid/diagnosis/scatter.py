"""What elements that are off by themselves do to a fit: its parameters take it up, and no residual shows it.

The user's uncertainties are of groups of elements as wholes; recordings tell natural frequencies far better than any
model has them element by element. To first order the parameters move by H^-1 J^T c with each response c to an element's
own deviation; H is the normal matrix and J the Jacobian of the fit.
"""

from dataclasses import replace

import numpy as np

from fe_models.effects import StiffnessChange
from hybrid.diagnosis.candidate import Candidate
from hybrid.diagnosis.fitting import Fit
from hybrid.diagnosis.frame import Frame
from hybrid.diagnosis.screening import slopes_along

OWN = 0.25  # of a group's stated standard deviation of stiffness: that of each of its elements about the group's


def with_scatter(item: Fit, candidates: tuple[Candidate, ...], stiffness: float, frame: Frame) -> Fit:
    """Return the fit with the covariance that it has if each element's stiffness is off by itself.

    ``candidates``: all, of which the changes of single elements are taken; ``stiffness``: stated relative standard
    deviation. A chain's elements are no groups: each is calibrated by itself.
    """
    taken = {candidate.key for candidate in item.hypothesis.candidates}
    elements = [c for c in candidates if c.kind == StiffnessChange.kind and "element" in c.location]
    elements = [c for c in elements if c.key not in taken]
    if item.hypothesis.plant.is_chain or stiffness == 0 or not elements:
        return item
    moved = OWN * stiffness * item.covariance @ slopes_along(item, elements, frame)  # (parameter, element)
    return replace(item, covariance=np.asarray(item.covariance + moved @ moved.T))
