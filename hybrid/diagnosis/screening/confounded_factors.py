"""Causes that do what an uncertain factor does: a calibration far off has taken their place, and hides them from the
score test.
"""

import numpy as np

from fe_models.causes import StiffnessChange
from fe_models.causes.candidate import Candidate, ModeCandidate
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.screening.screening import Screened


def confounded_candidates(fit: Fit, candidates: tuple[Candidate, ...]) -> list[Screened]:
    """Return those candidates at what the calibration of a ``fit`` has made of their factors, which go back to nominal.

    Most promising first: as far as the factor is off, squared, the sum of squares will fall.
    """
    found = []
    for candidate in candidates:
        number = _factor_of(candidate, fit.hypothesis.nominal)
        if number is not None:
            amount, shift = float(fit.theta[number]), np.zeros_like(fit.theta)
            shift[number] = -amount
            start = (candidate.neutral[0] * float(np.exp(amount)),)
            found.append(Screened(candidate, start, amount**2 * float(fit.hypothesis.precision[number]), shift))
    return sorted(found, key=lambda trial: -trial.gain)


def _factor_of(candidate: Candidate, nominal: NominalModel) -> int | None:
    """Return the number of the uncertain factor that does the same as a candidate, None without one."""
    if isinstance(candidate, ModeCandidate):
        return len(nominal.parts) + candidate.mode if candidate.mode < len(nominal.ratios) else None
    if candidate.kind == StiffnessChange.kind:
        for number, part in enumerate(nominal.parts):
            if part.quantity == "stiffness" and part.location == candidate.location:
                return number
    return None
