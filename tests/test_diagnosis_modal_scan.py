"""Causes behind a calibration gone astray, by the modes that it was needed for; and damping that turns with modes."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fe_models.blind import BlindCase, BlindConfig, blind_case
from fe_models.effects import AddedMass, QuadraticDamper
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.contest.growing import fit_growing
from hybrid.diagnosis.contest.setting import Setting, setting_of
from hybrid.diagnosis.contest.shortlist import HOPEFUL
from hybrid.diagnosis.fitting.fitting import fit
from hybrid.diagnosis.screening.modal_scan import modal_scan
from hybrid.diagnosis.screening.screening import screen

SHORT = BlindConfig(structure="bridge", rich=False, size=1.0, train=2, test=1, duration=6.0)


@cache
def case_of(seed: int, *kinds: str, off: bool = True) -> tuple[BlindCase, Setting, tuple[Candidate, ...]]:
    case = blind_case(seed, replace(SHORT, kinds=kinds, off=off))
    setting = setting_of(case.dataset)
    return case, setting, setting.candidates()


def hidden(case: BlindCase, candidates: tuple[Candidate, ...]) -> list[Candidate]:
    return [next(c for c in candidates if c.kind == t.kind and c.location == t.location) for t in case.truth]


def test_cause_that_led_a_calibration_astray_is_ranked_by_its_modes() -> None:
    """A mass on the deck beside drag: frequencies are far off, and phases of 8 s no longer linear in its size."""
    case, setting, candidates = case_of(440004, "quadratic_damper", "added_mass")
    drag, mass = case.truth
    first, second = hidden(case, candidates)
    assert isinstance(drag, QuadraticDamper)
    assert isinstance(mass, AddedMass)
    frame, start = setting.searched, np.append(setting.short.theta, drag.coefficient)
    item = fit_growing(setting.nominal.adding(first), start, setting.lengths, frame, setting.short)
    assert item is not None
    others = tuple(c for c in candidates if c is not first)
    ranked = modal_scan(item, others, frame, item)
    assert ranked[0].candidate.key == second.key
    assert ranked[0].start[0] == pytest.approx(mass.mass, rel=0.5)  # of first order in factors far off
    usual = [trial.candidate.key for trial in screen(item, others, frame)]
    assert usual.index(second.key) >= 10  # of which none goes on


def test_modes_ask_for_no_cause_where_there_is_none() -> None:
    _, setting, candidates = case_of(3, off=False)
    item = fit_growing(setting.nominal, setting.nominal.centre, setting.lengths, setting.searched, setting.short)
    assert item is not None
    assert modal_scan(item, candidates, setting.searched, item)[0].gain < HOPEFUL


def test_damping_turns_with_the_modes_where_the_recordings_say_so() -> None:
    """The hidden bridge's damping ratios are off in its own modes, which the mass in them has turned."""
    case, setting, candidates = case_of(20, "added_mass")
    (cause,) = case.truth
    assert isinstance(cause, AddedMass)
    (right,) = hidden(case, candidates)
    hypothesis, frame, lengths = setting.nominal.adding(right), setting.searched, setting.lengths
    item = fit_growing(hypothesis, np.append(setting.short.theta, cause.mass), lengths, frame, setting.short)
    assert item is not None
    std = np.sqrt(np.diag(item.covariance))
    turning = hypothesis.plant.values
    assert item.theta[-1] == pytest.approx(cause.mass, abs=3 * std[-1])
    assert item.theta[turning] > 3 * std[turning]  # 1: turns, -1: stays


def test_what_recordings_do_not_tell_stays_as_uncertain_as_it_was() -> None:
    """Though a value of a frame tells a quarter of what it does alone, what is known of it is no less certain."""
    _, setting, _ = case_of(3, off=False)
    item = fit(setting.nominal, setting.nominal.centre, setting.lengths.cut[0], setting.searched)
    assert item is not None
    plant = setting.plant
    spare = plant.factors - 1  # the damping of a mode that only a cause would bring
    assert plant.alike * item.covariance[spare, spare] == pytest.approx(plant.spread[spare] ** 2)
