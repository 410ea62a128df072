"""Two causes at once: what the larger one hides of the other."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.effects import CubicSpring, StiffnessChange
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.contest import pairs
from hybrid.diagnosis.contest.growing import Ground, Lengths, fit_growing, ground_of
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.contest.search import contest
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.fitting.fitting import Fit
from tests.masts import masts, recorded

SPRING = CubicSpring((3,), "x", 2e8)  # N/m^3: at 2 cm half as stiff as a mast
LOST = StiffnessChange((2,), 0.1)


def test_what_is_large_begins_beside_a_law_as_it_ended_alone() -> None:
    """No scan serves beside a law, and the score test of a storey all but lost leads elsewhere."""
    setting = setting_of(recorded(masts(middle=3.0), SPRING, LOST))
    candidates, lengths, gauge = setting.candidates(), setting.lengths, setting.gauge
    first, second = (
        next(c for c in candidates if (c.kind, c.location) == (kind, place))
        for kind, place in ((SPRING.kind, {"node": 3, "direction": "x"}), (LOST.kind, {"element": 2}))
    )
    begun = np.append(setting.nominal.centre, SPRING.stiffness)
    ground = ground_of(setting.nominal.adding(first), begun, lengths, gauge, setting.short)
    alone = fit_growing(setting.nominal.adding(second), np.append(setting.nominal.centre, 0.3), lengths, gauge)
    assert ground is not None
    assert alone is not None
    linear = tuple(candidate for candidate in candidates if candidate.changes is not None)
    best = contest(ground, linear, lengths, gauge, alone=(alone,))[0]
    assert best.hypothesis.candidates == (first, second)
    assert best.theta[-1] == pytest.approx(LOST.factor, rel=0.02)
    # Begun in the shapes of the intact masts, the motion has a share of a mode at 78 Hz, beyond half the sampling rate,
    # which no mode fitted shows: 28 times the noise's energy. It moves the factor by 0.4 %.


@pytest.mark.parametrize(
    ("kind", "leaves", "anew"),
    [("stiffness_change", 0.4, True), ("stiffness_change", 0.6, False), ("cubic_spring", 0.4, False)],
)
def test_first_cause_of_a_frame_is_looked_for_anew_where_a_second_one_does_more_unless_that_is_a_law(
    kind: str, leaves: float, anew: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A harmonic force may stand for a spring that softens, until what else is wrong is known."""
    setting, begun = setting_of(recorded(masts())), list[str]()
    ground = ground_of(setting.nominal, setting.nominal.centre, setting.lengths, setting.gauge)
    assert ground is not None
    base, by_kind = ground.whole, {candidate.kind: candidate for candidate in setting.candidates()}
    first, second = by_kind["added_mass"], by_kind[kind]

    def leaving(share: float, *causes: Candidate) -> Fit:
        loud = tuple(part + 10 * np.sin(0.3 * np.arange(part.shape[1]))[:, None] for part in base.residuals)  # 5 Hz
        cost = base.cost - base.misfit + share * 1e6
        return replace(base, hypothesis=replace(base.hypothesis, candidates=causes), residuals=loud, cost=cost)

    alone, pair = leaving(1.0, first), leaving(leaves, first, second)

    def with_ground(start: Fit, *_: object) -> tuple[Ground, Lengths, Fit]:
        begun.append(start.hypothesis.candidates[-1].kind)
        return replace(ground, whole=alone), setting.lengths, base

    monkeypatch.setattr(pairs, "ground_with", with_ground)
    monkeypatch.setattr(pairs, "contest", lambda *_, **__: (pair,))
    monkeypatch.setattr(pairs, "each_alone", lambda *_: [])
    posterior = Posterior((alone, leaving(5.0)), np.full(2, 1 / 2), 1.0)
    assert pair in pairs.pair_fits(posterior, (), setting.lengths.whole, setting.gauge, setting.band, lambda: None)
    assert begun == [first.kind, *([kind] if anew else [])]
