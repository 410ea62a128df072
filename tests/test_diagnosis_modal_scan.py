"""Causes behind a calibration gone astray, by the modes that it was needed for; and damping that turns with modes."""

from functools import cache

import numpy as np
import pytest

from benchmarks.blind_cases import BlindCase, BlindConfig, Tier, blind_case
from fe_models.causes import AddedMass
from fe_models.causes.candidate import Candidate
from hybrid.diagnosis.contest.config import SHORTLIST
from hybrid.diagnosis.contest.growing import fit_growing
from hybrid.diagnosis.contest.setting import Setting, setting_of
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.screening.modal_scan import modal_scan


@cache
def case_of(
    seed: int, *kinds: str, tier: Tier = "off", size: float = 0.6, duration: float = 6.0
) -> tuple[BlindCase, Setting, tuple[Candidate, ...]]:
    case = blind_case(
        seed, BlindConfig(kinds, tier, size=size, train=2, duration=duration, structure="bridge", rich=False)
    )
    setting = setting_of(case.dataset)
    return case, setting, setting.candidates()


def hidden(case: BlindCase, candidates: tuple[Candidate, ...]) -> list[Candidate]:
    return [next(c for c in candidates if c.kind == t.kind and c.location == t.location) for t in case.truth]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "kind"), [(30, "added_mass"), (34, "added_mass"), (30, "stiffness_change")], ids=["tower", "deck", "cable"]
)
def test_cause_that_led_a_calibration_astray_is_ranked_first_by_its_modes(seed: int, kind: str) -> None:
    case, setting, candidates = case_of(seed, kind)
    (cause,), (right,) = case.truth, hidden(case, candidates)
    item = fit_growing(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths, setting.searched, setting.short
    )
    assert item is not None
    assert np.abs(item.deviations).max() > 5
    first = modal_scan(item, candidates, setting.searched, item)[0]
    assert first.candidate.key == right.key
    assert first.start[0] == pytest.approx(cause.parameters[right.names[0]], rel=0.35)  # of first order in the factors
    assert (
        np.abs(first.theta(item)[: setting.nominal.values] / setting.nominal.spread[: setting.nominal.values]).max() < 5
    )


@pytest.mark.slow
def test_modes_ask_for_no_cause_where_there_is_none() -> None:
    _, setting, candidates = case_of(3, tier="exact")
    item = fit_growing(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths, setting.searched, setting.short
    )
    assert item is not None
    assert modal_scan(item, candidates, setting.searched, item)[0].gain < SHORTLIST.min_promised_fall


@pytest.mark.slow
def test_damping_turns_with_the_modes_where_the_recordings_say_so() -> None:
    """The hidden bridge's damping ratios are off in its own modes, which the mass in them has turned."""
    case, setting, candidates = case_of(20, "added_mass", size=1.0, duration=12.0)
    (cause,) = case.truth
    assert isinstance(cause, AddedMass)
    (right,) = hidden(case, candidates)
    hypothesis, noise_model, lengths = setting.nominal_hypothesis.adding(right), setting.searched, setting.lengths
    item = fit_growing(hypothesis, np.append(setting.short.theta, cause.mass), lengths, noise_model, setting.short)
    assert item is not None
    std = np.sqrt(np.diag(item.covariance))
    turning = hypothesis.nominal.values
    assert item.theta[-1] == pytest.approx(cause.mass, abs=3 * std[-1])
    assert item.theta[turning] > 3 * std[turning]  # 1: turns, -1: stays


@pytest.mark.slow
def test_what_recordings_do_not_tell_stays_as_uncertain_as_it_was() -> None:
    """Though a value of a frame tells a quarter of what it does alone, what is known of it is no less certain."""
    _, setting, _ = case_of(3, tier="exact")
    item = fit(setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths.cut[0], setting.searched)
    assert item is not None
    nominal = setting.nominal
    spare = nominal.factors - 1  # the damping of a mode that only a cause would bring
    assert nominal.alike * item.covariance[spare, spare] == pytest.approx(nominal.spread[spare] ** 2)
