"""Two causes at once: what the larger one hides of the other."""

import numpy as np
import pytest

from fe_models.causes import CubicSpring, StiffnessChange
from fe_models.causes.candidate import MatrixCandidate
from hybrid.diagnosis.contest.growing import fit_growing, reference_fits_of
from hybrid.diagnosis.contest.search import contest
from hybrid.diagnosis.contest.setting import setting_of
from tests.masts import masts, recorded

SPRING = CubicSpring((3,), "x", 2e8)  # N/m^3: at 2 cm half as stiff as a mast
LOST = StiffnessChange((2,), 0.1)


@pytest.mark.slow
def test_what_is_large_begins_beside_a_law_as_it_ended_alone() -> None:
    """No scan serves beside a law, and the score test of a storey all but lost leads elsewhere."""
    setting = setting_of(recorded(masts(middle=3.0), SPRING, LOST))
    candidates, lengths, noise_model = setting.candidates(), setting.lengths, setting.noise_model
    first, second = (
        next(c for c in candidates if (c.kind, c.location) == (kind, place))
        for kind, place in ((SPRING.kind, {"node": 3, "direction": "x"}), (LOST.kind, {"element": 2}))
    )
    begun = np.append(setting.nominal_hypothesis.centre, SPRING.stiffness)
    ground = reference_fits_of(setting.nominal_hypothesis.adding(first), begun, lengths, noise_model, setting.short)
    alone = fit_growing(
        setting.nominal_hypothesis.adding(second),
        np.append(setting.nominal_hypothesis.centre, 0.3),
        lengths,
        noise_model,
    )
    assert ground is not None
    assert alone is not None
    linear = tuple(candidate for candidate in candidates if isinstance(candidate, MatrixCandidate))
    best = contest(ground, linear, lengths, noise_model, alone=(alone,))[0]
    assert best.hypothesis.candidates == (first, second)
    assert best.theta[-1] == pytest.approx(LOST.factor, rel=0.02)
    # Begun in the shapes of the intact masts, the motion has a share of a mode at 78 Hz, beyond half the sampling rate,
    # which no mode fitted shows: 28 times the noise's energy. It moves the factor by 0.4 %.
