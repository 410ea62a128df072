"""Two causes at once: what the larger one hides of the other."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.causes import CubicSpring, StiffnessChange
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.contest import pairs
from hybrid.diagnosis.contest.growing import Lengths, ReferenceFits, fit_growing, reference_fits_of
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.contest.search import contest
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.fitting.least_squares import Fit
from tests.masts import masts, recorded

SPRING = CubicSpring((3,), "x", 2e8)  # N/m^3: at 2 cm half as stiff as a mast
LOST = StiffnessChange((2,), 0.1)


def test_what_is_large_begins_beside_a_law_as_it_ended_alone() -> None:
    """No scan serves beside a law, and the score test of a storey all but lost leads elsewhere."""
    setting = setting_of(recorded(masts(middle=3.0), SPRING, LOST))
    candidates, lengths, noise_model = setting.candidates(), setting.lengths, setting.noise_model
    first, second = (
        next(c for c in candidates if (c.kind, c.location) == (kind, place))
        for kind, place in ((SPRING.kind, {"node": 3, "direction": "x"}), (LOST.kind, {"element": 2}))
    )
    begun = np.append(setting.nominal.centre, SPRING.stiffness)
    ground = reference_fits_of(setting.nominal.adding(first), begun, lengths, noise_model, setting.short)
    alone = fit_growing(setting.nominal.adding(second), np.append(setting.nominal.centre, 0.3), lengths, noise_model)
    assert ground is not None
    assert alone is not None
    linear = tuple(candidate for candidate in candidates if candidate.changes is not None)
    best = contest(ground, linear, lengths, noise_model, alone=(alone,))[0]
    assert best.hypothesis.candidates == (first, second)
    assert best.theta[-1] == pytest.approx(LOST.factor, rel=0.02)
    # Begun in the shapes of the intact masts, the motion has a share of a mode at 78 Hz, beyond half the sampling rate,
    # which no mode fitted shows: 28 times the noise's energy. It moves the factor by 0.4 %.


@pytest.mark.parametrize(
    ("kind", "leaves", "over", "anew"),
    [
        ("stiffness_change", 0.4, 2.0, True),
        ("stiffness_change", 0.6, 2.0, False),
        ("stiffness_change", 0.4, 1.3, False),
        ("cubic_spring", 0.4, 2.0, False),
    ],
)
def test_first_cause_of_a_frame_is_looked_for_anew_once_where_a_second_one_that_is_no_law_halves_what_it_leaves(
    kind: str, leaves: float, over: float, anew: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A harmonic force may stand for a spring that softens, until what else is wrong is known; not where the energy
    left is little ``over`` that of noise. The next single cause has its turn after that, however much is left.
    """
    setting, begun = setting_of(recorded(masts())), list[str]()
    ground = reference_fits_of(setting.nominal, setting.nominal.centre, setting.lengths, setting.noise_model)
    assert ground is not None
    base, by_kind = ground.whole, {candidate.kind: candidate for candidate in setting.candidates()}
    first, other, second = by_kind["added_mass"], by_kind["modal_damping"], by_kind[kind]

    def leaving(share: float, *causes: Candidate) -> Fit:
        loud = tuple(part + 10 * np.sin(0.3 * np.arange(part.shape[1]))[:, None] for part in base.residuals)  # 5 Hz
        hypothesis = replace(base.hypothesis, candidates=causes)
        theta = np.append(base.theta, hypothesis.centre[len(base.theta) :])
        cost, covariance = base.cost - base.misfit + share * 1e6, np.diag(hypothesis.width**2)
        found = replace(base, hypothesis=hypothesis, theta=theta, covariance=covariance)
        return replace(found, residuals=loud, cost=cost, chi2=over * base.values)

    found = {first.key: (leaving(leaves, first, second),), second.key: (leaving(0.39, second, first),), other.key: ()}

    def with_ground(start: Fit, *_: object) -> tuple[ReferenceFits, Lengths, Fit]:
        held = start.hypothesis.candidates[-1]
        begun.append(held.kind)
        return replace(ground, whole=leaving(1.0, held)), setting.lengths, base

    def seconds(beside: ReferenceFits, *_: object, **__: object) -> tuple[Fit, ...]:
        return found[beside.hypothesis.candidates[-1].key]

    monkeypatch.setattr(pairs, "reference_fits_with", with_ground)
    monkeypatch.setattr(pairs, "contest", seconds)
    monkeypatch.setattr(pairs, "each_alone", lambda *_: [])
    singles = leaving(1.0, first), leaving(1.0, other)
    posterior = Posterior((*singles, leaving(1.2)), np.full(3, 1 / 3), 1.0, 1.0)
    pairs.pair_fits(posterior, (), setting.lengths.whole, setting.noise_model, setting.band, lambda: None)
    assert begun == [first.kind, *([kind] if anew else []), other.kind]
