"""Where forces are looked for on a frame: at its nodes, at the next ones, between parts that stand side by side."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fe_models.blind import SENSORS as CHAIN_SENSORS
from fe_models.bridge import bridge
from fe_models.effects import CoulombFriction, CubicSpring, GapStop
from fe_models.four_dof import four_dof
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import Beam, Spring, Structure
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.causes.force_causes import force_laws_of
from hybrid.diagnosis.causes.linear_causes import ECHOED, linear_causes
from hybrid.diagnosis.causes.places import Motion, places_of
from hybrid.diagnosis.contest import neighbours, pairs, search, stages
from hybrid.diagnosis.contest.growing import fit_growing, ground_of, passed_by, shortened
from hybrid.diagnosis.contest.neighbours import adjoin, fits_beside, fits_tied, laws_beside, of_other_kinds
from hybrid.diagnosis.contest.pairs import asks_for_more
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.contest.search import others_there
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.contest.stages import Search
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.fitting.fitting import Fit, fit
from hybrid.diagnosis.nominal.plant import plant_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.recorded.records import Batch
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.screening.force_screening import screen_forces
from hybrid.diagnosis.screening.screening import Screened
from hybrid.progress import nothing
from tests.frames import beam, vibrations
from tests.masts import RATE, SENSORS, TUBE, masts, recorded

WHITE = np.random.default_rng(0).standard_normal((1, 200, 5))
CHAIN = Dataset(four_dof(), 10.0, CHAIN_SENSORS, (Recording("r", WHITE),))
STIFF = 5e7  # N/m^3: at 2 cm a seventh as stiff as a mast


def pairs_of(structure: Structure) -> list[Any]:
    """The pairs of nodes between which forces are looked for."""
    rng = np.random.default_rng(0)
    recording = Recording("r", rng.standard_normal((1, 200, len(SENSORS))))
    plant = plant_of(Dataset(structure, RATE, SENSORS, (recording,)))
    motion = Motion.of_states(rng.standard_normal((50, 2 * plant.size)), plant)
    return [(place.location["nodes"], place.direction) for place in places_of(plant, motion) if len(place.nodes) == 2]


def test_spring_beside_one_to_the_ground_is_less_probable_than_that_one_off() -> None:
    plant = plant_of(CHAIN)
    motion = Motion(*np.random.default_rng(0).standard_normal((2, 50, 4)))
    springs = [c for c in linear_causes(plant, places_of(plant, motion)) if c.kind == "support_spring"]
    assert [(c.location["node"], c.weight) for c in springs] == [(1, ECHOED), (2, 1.0), (3, 1.0), (4, 1.0)]


def test_no_force_law_is_looked_for_where_nothing_moves() -> None:
    """A beam whose sensors look across moves along by rounding only, and a stop there would have no gap."""
    rng = np.random.default_rng(0)
    across = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 3, 5))
    structure = beam()
    plant = plant_of(Dataset(structure, 600.0, across, (Recording("r", rng.standard_normal((1, 200, 3))),)))
    most = {word: np.abs(plant.modes[1][plant.dofs.direction == word, : plant.size]).max(axis=0) for word in ("x", "y")}
    along = most["x"] > most["y"]
    assert along.any()
    states = rng.standard_normal((50, 2, plant.size)) * np.where(along, 1e-12, 1.0)
    motion = Motion.of_states(states.reshape(50, -1), plant)
    places = places_of(plant, motion)
    assert {place.direction for place in places} == {"x", "y"}
    laws = force_laws_of(plant, places, motion)
    assert {law.location["direction"] for law in laws} == {"y"}
    still = Motion(np.zeros((50, len(plant.dofs))), np.zeros((50, len(plant.dofs))))
    assert force_laws_of(plant, places, still) == []


def test_harmonic_forces_turn_once_in_a_recording_at_least() -> None:
    setting = setting_of(CHAIN)
    forces = tuple(c for c in setting.candidates() if c.oscillator)
    slowest = 10.0 / setting.lengths.whole[0].samples  # Hz
    assert [c.lower for c in forces] == [(slowest,)] * 4
    base = fit(setting.nominal, setting.nominal.centre, setting.lengths.whole, setting.gauge)
    assert base is not None
    assert min(trial.start[0] for trial in screen_forces(base, forces, setting.gauge)) >= slowest


def test_nodes_of_parts_side_by_side_are_pairs() -> None:
    assert pairs_of(masts()) == [([2, 5], "x"), ([3, 6], "x")]  # along the masts nothing moves


def test_what_is_far_apart_or_joined_by_a_beam_is_no_pair() -> None:
    assert pairs_of(masts(apart=2.0)) == []
    joined = masts()
    assert ([3, 6], "x") not in pairs_of(replace(joined, elements=(*joined.elements, Beam((3, 6), TUBE))))


def test_ends_of_a_spring_are_a_pair_however_far_apart() -> None:
    far = masts(apart=3.0)
    assert pairs_of(replace(far, elements=(*far.elements, Spring((6, 3), "x", 1e3)))) == [([3, 6], "x")]


def test_deck_and_tower_of_the_bridge_are_a_pair_where_they_cross() -> None:
    structure = bridge()
    crossing = [(structure.nodes[i - 1], structure.nodes[j - 1]) for i, j in ((7, 32), (23, 45))]
    assert all(one == other for one, other in crossing)
    assert {tuple(pair) for pair, _ in pairs_of(structure)} == {(7, 32), (23, 45)}


@pytest.mark.parametrize(
    "effect", [GapStop((3, 6), "x", 0.005, 2e5, 1), CoulombFriction((3, 6), "x", 15.0, 1e-3)], ids=lambda e: e.kind
)
def test_masts_that_knock_or_rub_are_told(effect: GapStop | CoulombFriction) -> None:
    found = diagnose(recorded(masts(), effect))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == (effect.kind, effect.location)
    assert finding.probability > 0.9
    word = "gap" if isinstance(effect, GapStop) else "force"
    value = finding.parameters[word]
    assert value.value == pytest.approx(effect.parameters[word], rel=0.1)  # the contract's bound
    assert found.scores["extended"]["measured"] == pytest.approx(found.noise_floor, rel=0.05)


def test_the_node_next_to_the_one_found_is_fitted_and_goes_on_to_the_right_one() -> None:
    setting = setting_of(recorded(masts(middle=3.0), CubicSpring((3,), "x", STIFF)))
    candidates = setting.candidates()
    base = fitted(setting.short, setting.lengths.whole, setting.gauge)
    here, right = (
        next(c for c in candidates if c.kind == "cubic_spring" and c.location == {"node": node, "direction": "x"})
        for node in (2, 3)
    )
    hypothesis = setting.nominal.adding(here)
    best = fit(hypothesis, np.append(base.theta, 0.1 * here.width[0]), base.batches, setting.gauge, base.states)
    assert best is not None
    found = fits_beside(best, base, candidates, setting.gauge, lambda: None, ())
    assert [item.hypothesis.candidates[0].key for item in found] == [right.key]
    assert found[0].log_evidence > best.log_evidence + 100
    assert found[0].theta[-1] == pytest.approx(STIFF, rel=0.1)  # the contract's bound


@pytest.mark.parametrize(("temper", "places"), [(1e-6, {2, 4}), (1e6, {2, 4, 5, 6, 7})])
def test_places_that_do_as_well_are_fitted_one_after_the_other(temper: float, places: set[int]) -> None:
    """Where recordings tell little, the right one may be any number of nodes away, up to the roller."""
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    candidates = tuple(c for c in setting.candidates() if c.kind == "added_mass")
    base = fitted(setting.short, setting.lengths.whole, setting.gauge)
    (here,) = (c for c in candidates if c.location == {"node": 3})
    best = fit(setting.nominal.adding(here), np.append(base.theta, 0.0), base.batches, setting.gauge)
    assert best is not None
    found = fits_tied([best], temper, candidates, setting.gauge, nothing)
    assert {item.hypothesis.candidates[0].location["node"] for item in found} == places


def test_no_cause_moves_to_where_another_one_of_its_kind_is() -> None:
    """Two halves of one cause would do the same as the whole, and cost less beforehand."""
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    masses = {c.location["node"]: c for c in setting.candidates() if c.kind == "added_mass"}
    both, short = Hypothesis(setting.plant, (masses[3], masses[4])), setting.short
    best = fit(both, np.append(short.theta, (0.0, 0.0)), short.batches, setting.gauge)
    assert best is not None
    found = fits_tied([best], 1e-6, tuple(masses.values()), setting.gauge, nothing)
    places = {tuple(c.location["node"] for c in item.hypothesis.candidates) for item in found}
    assert {(2, 4), (3, 5)} <= places
    assert all(one != other for one, other in places)


@pytest.mark.parametrize(("one", "other", "adjoins"), [(2, 3, True), (2, 4, False)])
def test_causes_adjoin_at_nodes_that_an_element_joins(one: int, other: int, adjoins: bool) -> None:
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    masses = {c.location["node"]: c for c in setting.candidates() if c.kind == "added_mass"}
    both = replace(setting.short, hypothesis=Hypothesis(setting.plant, (masses[one], masses[other])))
    assert adjoin(both) == adjoins


@pytest.mark.parametrize(("one", "other", "adjoins"), [(2, 2, True), (2, 3, False)])
def test_causes_adjoin_on_a_chain_at_one_place_only(one: int, other: int, adjoins: bool) -> None:
    """Friction and a dashpot at one node are what a force with the root of the velocity looks like."""
    setting = setting_of(CHAIN)
    found = [
        next(c for c in setting.candidates() if c.kind == kind and c.location == {"node": node, "direction": "x"})
        for kind, node in (("coulomb_friction", one), ("point_damper", other))
    ]
    assert adjoin(replace(setting.short, hypothesis=Hypothesis(setting.plant, tuple(found)))) == adjoins


def test_other_kinds_of_cause_sit_where_the_one_found_does() -> None:
    """A mass at either end of an element does what its stiffness does, with a calibration that goes along."""
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    softer = next(c for c in setting.candidates() if c.kind == "stiffness_change" and c.location == {"element": 2})
    short = setting.short
    best = fit(setting.nominal.adding(softer), np.append(short.theta, 1.0), short.batches, setting.gauge)
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
        return replace(short, hypothesis=setting.nominal.adding(stop), theta=theta, cost=cost, chi2=cost)

    seen = []

    def begin(trials: list[Screened], known: Fit) -> list[Fit]:
        seen.append([trial.candidate.location["node"] for trial in trials])
        return [left_at(trial.candidate) for trial in trials]

    trials = [Screened(stop, stop.first_starts[0], 1.0, np.zeros_like(short.theta)) for stop in stops]
    (first,) = (stop for stop in stops if stop.location == {"node": 2, "direction": "y", "side": 1})
    found = laws_beside([left_at(first)], trials, begin)
    assert seen == begun_at
    assert [item.hypothesis.candidates[-1].location["node"] for item in found] == [node for (node,) in begun_at]


def test_a_contest_begins_laws_beside_the_best_of_its_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    masses = tuple(c for c in setting.candidates() if c.kind == "added_mass")
    ground = ground_of(setting.nominal, setting.nominal.centre, setting.lengths, setting.gauge, setting.short)
    assert ground is not None
    asked = []

    def none_beside(present: list[Fit], trials: list[Screened], begin: Any) -> list[Fit]:
        asked.append((len(present), {trial.candidate.key for trial in trials}))
        return begin([], present[0])

    monkeypatch.setattr(search, "laws_beside", none_beside)
    search.contest(ground, masses, setting.lengths, setting.gauge)
    ((fits, trials),) = asked
    assert fits > 0
    assert trials == {mass.key for mass in masses}


def test_the_places_next_to_what_explains_little_are_not_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    setting = setting_of(recorded(masts(middle=3.0), CubicSpring((3,), "x", STIFF)))
    candidates = setting.candidates()
    base = fitted(setting.short, setting.lengths.whole, setting.gauge)
    (damper,) = (c for c in candidates if c.kind == "point_damper" and c.location == {"node": 2, "direction": "x"})
    guess = fit(setting.nominal.adding(damper), np.append(base.theta, 0.0), base.batches, setting.gauge)
    assert guess is not None
    assert fits_beside(guess, base, candidates, setting.gauge, lambda: None, ()) == []
    monkeypatch.setattr(neighbours, "LITTLE", 1.0)
    assert fits_beside(guess, base, candidates, setting.gauge, lambda: None, ())


def fitted(short: Fit, batches: tuple[Batch, ...], gauge: Gauge) -> Fit:
    """The nominal fit of whole recordings."""
    found = fit(short.hypothesis, short.theta, batches, gauge)
    assert found is not None
    return found


def test_frame_that_forecasts_well_is_searched_further_where_it_leaves_half_as_much_again_as_noise() -> None:
    setting = setting_of(recorded(masts()))
    ground = ground_of(setting.nominal, setting.nominal.centre, setting.lengths, setting.gauge)
    assert ground is not None
    search = Search(ground, setting.lengths, (), setting.gauge, setting.gauge, setting.band, str)
    base = ground.whole
    more = tuple(1.4 * part for part in base.residuals)  # twice the energy
    assert search.is_ample(base)
    assert not search.is_ample(replace(base, residuals=more, chi2=1.96 * base.chi2))


@pytest.mark.parametrize(("rest", "asks"), [(0.75, True), (0.85, False)])
def test_second_cause_is_looked_for_unless_the_first_leaves_most_of_what_is_wrong(rest: float, asks: bool) -> None:
    setting = setting_of(recorded(masts()))
    ground = ground_of(setting.nominal, setting.nominal.centre, setting.lengths, setting.gauge)
    assert ground is not None
    base = ground.whole
    loud = tuple(part + 10 * np.sin(0.3 * np.arange(part.shape[1]))[:, None] for part in base.residuals)  # 5 Hz
    single = replace(base.hypothesis, candidates=setting.candidates()[:1])
    first = replace(base, hypothesis=single, residuals=loud, cost=base.cost - base.misfit + rest * 1e6)
    wrong = replace(base, cost=base.cost - base.misfit + 1e6)
    assert first.misfit == pytest.approx(rest * wrong.misfit)
    assert asks_for_more(first, wrong, setting.gauge, setting.band) is asks


@pytest.mark.parametrize(("behind", "count"), [(1.0, 2), (1e6, 1)])
def test_second_cause_of_a_frame_is_looked_for_beside_the_next_single_one_if_that_is_near(
    behind: float, count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    setting, begun = setting_of(recorded(masts())), list[Fit]()
    ground = ground_of(setting.nominal, setting.nominal.centre, setting.lengths, setting.gauge)
    assert ground is not None
    base = ground.whole
    singles = [
        replace(base, hypothesis=replace(base.hypothesis, candidates=(candidate,)), cost=base.cost + more)
        for candidate, more in zip(setting.candidates()[:2], (0.0, behind), strict=True)
    ]

    def none(start: Fit, *_: object) -> tuple[None, None, None]:
        begun.append(start)
        return None, None, None

    monkeypatch.setattr(pairs, "ground_with", none)
    posterior = Posterior((*singles, base), np.full(3, 1 / 3), 1.0)
    found = pairs.pair_fits(posterior, (), setting.lengths.whole, setting.gauge, setting.band, lambda: None)
    assert found == []
    assert [id(item) for item in begun] == [id(item) for item in singles[:count]]


@pytest.mark.parametrize(("better", "asks"), [("in some recordings", True), ("in all recordings", False)])
def test_change_of_a_frame_is_looked_for_beside_a_cause_unless_one_in_all_recordings_does_better_alone(
    better: str, asks: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stages, "changes_beside", lambda *_: ["looked for"])
    monkeypatch.setattr(Search, "is_enough", lambda *_: False)
    monkeypatch.setattr(stages, "is_hopeless", lambda *_: False)
    setting = setting_of(recorded(masts()))
    ground = ground_of(setting.nominal, setting.nominal.centre, setting.lengths, setting.gauge)
    assert ground is not None
    search = Search(ground, setting.lengths, setting.candidates(), setting.gauge, setting.gauge, setting.band, str)
    base = ground.whole
    (batch,) = base.batches
    before, after = (batch.take([i for i in range(len(batch.names)) if (i > 0) is late]) for late in (False, True))

    def with_causes(count: int, parted: bool, gain: float) -> Fit:
        hypothesis = replace(base.hypothesis, candidates=search.candidates[:count])
        theta = np.append(base.theta, hypothesis.centre[len(base.theta) :])
        covariance = np.diag(hypothesis.width**2)
        found = replace(base, hypothesis=hypothesis, theta=theta, covariance=covariance, cost=base.cost - gain)
        if not parted:
            return found
        residuals, states = ((part[:1], part[1:]) for (part,) in (base.residuals, base.states))
        return replace(found, batches=(replace(before, off=(0,)), after), residuals=residuals, states=states)

    known = [base, with_causes(2, parted=True, gain=1e5)]
    known += [
        with_causes(1, parted, 9e4 if parted is (better == "in some recordings") else 8e4) for parted in (False, True)
    ]
    assert search.posterior(known).fits[0] is known[1]
    assert bool(search.in_groups(known)) is asks


def test_short_segments_begin_where_the_motion_of_whole_recordings_passes() -> None:
    setting = setting_of(recorded(masts(middle=3.0), CubicSpring((3,), "x", 4 * STIFF)))
    place = {"node": 3, "direction": "x"}
    (spring,) = (c for c in setting.candidates() if c.kind == "cubic_spring" and c.location == place)
    hypothesis, gauge, segments = setting.nominal.adding(spring), setting.gauge, setting.lengths.cut[0]
    theta = np.append(setting.nominal.centre, 4 * STIFF)
    whole = fit_growing(hypothesis, theta, setting.lengths, gauge, setting.short)
    assert whole is not None
    own = fit(hypothesis, whole.theta, segments, gauge, passed_by(whole, segments, gauge))
    assert own is not None
    off = (passed_by(whole, segments, gauge)[0] - own.states[0]) / own.state_errors[0]
    assert np.sqrt(np.mean(off**2)) < 1.5  # of what noise alone makes of the states of a segment

    astray = tuple(-3 * states for states in own.states)
    stuck, found = fit(hypothesis, whole.theta, segments, gauge, astray), shortened(whole, segments, gauge, astray)
    assert stuck is not None
    assert found is not None
    assert stuck.cost > 10 * own.cost
    assert found.cost == pytest.approx(own.cost, rel=1e-3)
