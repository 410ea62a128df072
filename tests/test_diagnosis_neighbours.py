"""Places next to those that were found: fitted, going on where they do better, reported as one where they adjoin."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.causes import CubicSpring
from fe_models.causes.candidate import Candidate
from fe_models.progress import nothing
from fe_models.recordings import Sensor
from hybrid.diagnosis.contest.neighbours import adjoin, fits_beside, fits_tied, laws_beside, of_other_kinds
from hybrid.diagnosis.contest.search import others_there
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.screening.screening import Screened
from tests.frames import beam, vibrations
from tests.masts import masts, recorded

STIFF = 5e7  # N/m^3: at 2 cm a seventh as stiff as a mast


def fitted(short: Fit, batches: tuple[Batch, ...], noise_model: NoiseModel) -> Fit:
    """The nominal fit of whole recordings."""
    found = fit(short.hypothesis, short.theta, batches, noise_model)
    assert found is not None
    return found


def test_the_node_next_to_the_one_found_is_fitted_and_goes_on_to_the_right_one() -> None:
    setting = setting_of(recorded(masts(middle=3.0), CubicSpring((3,), "x", STIFF)))
    candidates = setting.candidates()
    base = fitted(setting.short, setting.lengths.whole, setting.noise_model)
    here, right = (
        next(c for c in candidates if c.kind == "cubic_spring" and c.location == {"node": node, "direction": "x"})
        for node in (2, 3)
    )
    hypothesis = setting.nominal_hypothesis.adding(here)
    best = fit(hypothesis, np.append(base.theta, 0.1 * here.width[0]), base.batches, setting.noise_model, base.states)
    assert best is not None
    found = fits_beside(best, base, candidates, setting.noise_model, lambda: None, ())
    assert [item.hypothesis.candidates[0].key for item in found] == [right.key]
    assert found[0].log_evidence > best.log_evidence + 100
    assert found[0].theta[-1] == pytest.approx(STIFF, rel=0.1)  # the contract's bound


@pytest.mark.slow
@pytest.mark.parametrize(("temper", "places"), [(1e-6, {2, 4}), (1e6, {2, 4, 5, 6, 7})])
def test_places_that_do_as_well_are_fitted_one_after_the_other(temper: float, places: set[int]) -> None:
    """Where recordings tell little, the right one may be any number of nodes away, up to the roller."""
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    candidates = tuple(c for c in setting.candidates() if c.kind == "added_mass")
    base = fitted(setting.short, setting.lengths.whole, setting.noise_model)
    (here,) = (c for c in candidates if c.location == {"node": 3})
    best = fit(setting.nominal_hypothesis.adding(here), np.append(base.theta, 0.0), base.batches, setting.noise_model)
    assert best is not None
    found = fits_tied([best], temper, candidates, setting.noise_model, nothing)
    assert {item.hypothesis.candidates[0].location["node"] for item in found} == places


@pytest.mark.slow
def test_no_cause_moves_to_where_another_one_of_its_kind_is() -> None:
    """Two halves of one cause would do the same as the whole, and cost less beforehand."""
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    masses = {c.location["node"]: c for c in setting.candidates() if c.kind == "added_mass"}
    both, short = Hypothesis(setting.nominal, (masses[3], masses[4])), setting.short
    best = fit(both, np.append(short.theta, (0.0, 0.0)), short.batches, setting.noise_model)
    assert best is not None
    found = fits_tied([best], 1e-6, tuple(masses.values()), setting.noise_model, nothing)
    places = {tuple(c.location["node"] for c in item.hypothesis.candidates) for item in found}
    assert {(2, 4), (3, 5)} <= places
    assert all(one != other for one, other in places)


@pytest.mark.slow
@pytest.mark.parametrize(("one", "other", "adjoins"), [(2, 3, True), (2, 4, False)])
def test_causes_adjoin_at_nodes_that_an_element_joins(one: int, other: int, adjoins: bool) -> None:
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    masses = {c.location["node"]: c for c in setting.candidates() if c.kind == "added_mass"}
    both = replace(setting.short, hypothesis=Hypothesis(setting.nominal, (masses[one], masses[other])))
    assert adjoin(both) == adjoins


@pytest.mark.parametrize(("one", "other", "adjoins"), [(2, 2, True), (2, 3, False)])
def test_causes_adjoin_on_a_chain_at_one_place_only(one: int, other: int, adjoins: bool) -> None:
    """Friction and a dashpot at one node are what a force with the root of the velocity looks like."""
    setting = setting_of(blind_case(3, BlindConfig(())).dataset)
    found = [
        next(c for c in setting.candidates() if c.kind == kind and c.location == {"node": node, "direction": "x"})
        for kind, node in (("coulomb_friction", one), ("point_damper", other))
    ]
    assert adjoin(replace(setting.short, hypothesis=Hypothesis(setting.nominal, tuple(found)))) == adjoins


@pytest.mark.slow
def test_other_kinds_of_cause_sit_where_the_one_found_does() -> None:
    """A mass at either end of an element does what its stiffness does, with a calibration that goes along."""
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    softer = next(c for c in setting.candidates() if c.kind == "stiffness_change" and c.location == {"element": 2})
    short = setting.short
    best = fit(
        setting.nominal_hypothesis.adding(softer), np.append(short.theta, 1.0), short.batches, setting.noise_model
    )
    assert best is not None
    trials = [Screened(c, c.neutral, 0.0, np.zeros_like(best.theta)) for c in setting.candidates()]
    there = [trial.candidate for trial in of_other_kinds(best, trials)]
    assert {c.kind for c in there} == {"added_mass", "support_spring", "point_damper", "axial_force"}
    nodes = {c.location["node"] for c in there if "node" in c.location}
    assert nodes == {2, 3}
    elements = [c.location["elements"] for c in there if "elements" in c.location]
    assert elements == [[1], [2], [3]]  # that meet there
    promising = [replace(trial, gain=1.0) for trial in trials]
    off = best.theta.copy()
    off[0] = 6 * best.hypothesis.width[0]
    far = replace(best, theta=off)
    assert others_there(best, [promising], []) == []  # its calibration is normal
    assert {trial.candidate.key for trial in others_there(far, [promising], [])} == {c.key for c in there}
    assert others_there(far, [promising], promising) == []  # all have been tried


@pytest.mark.slow
@pytest.mark.parametrize(("noisy", "begun_at"), [(True, [[3], [4], [5]]), (False, [])])
def test_a_law_begins_next_to_its_best_place_while_that_gets_better(noisy: bool, begun_at: list[list[int]]) -> None:
    """And not where it leaves noise alone."""
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    short, stops = setting.short, [c for c in setting.candidates() if c.kind == "gap_stop" and c.location["side"] == 1]
    energy = {2: 9.0, 3: 8.0, 4: 5.0, 5: 7.0}  # of noise

    def left_at(stop: Candidate) -> Fit:
        cost = short.values * (energy[stop.location["node"]] if noisy else 1.0)
        theta = np.append(short.theta, stop.first_starts[0])
        return replace(short, hypothesis=setting.nominal_hypothesis.adding(stop), theta=theta, cost=cost, chi2=cost)

    seen = []

    def begin(trials: list[Screened], known: Fit) -> list[Fit]:
        seen.append([trial.candidate.location["node"] for trial in trials])
        return [left_at(trial.candidate) for trial in trials]

    trials = [Screened(stop, stop.first_starts[0], 1.0, np.zeros_like(short.theta)) for stop in stops]
    (first,) = (stop for stop in stops if stop.location == {"node": 2, "direction": "y", "side": 1})
    found = laws_beside([left_at(first)], trials, begin)
    assert seen == begun_at
    assert [item.hypothesis.candidates[-1].location["node"] for item in found] == [node for (node,) in begun_at]


def test_the_places_next_to_what_explains_little_are_not_fitted() -> None:
    setting = setting_of(recorded(masts(middle=3.0), CubicSpring((3,), "x", STIFF)))
    candidates = setting.candidates()
    base = fitted(setting.short, setting.lengths.whole, setting.noise_model)
    (damper,) = (c for c in candidates if c.kind == "point_damper" and c.location == {"node": 2, "direction": "x"})
    guess = fit(
        setting.nominal_hypothesis.adding(damper), np.append(base.theta, 0.0), base.batches, setting.noise_model
    )
    assert guess is not None
    assert fits_beside(guess, base, candidates, setting.noise_model, lambda: None, ()) == []
