"""Where forces are looked for on a frame: at its nodes, at the next ones, between parts that stand side by side."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.blind_cases import SENSORS as CHAIN_SENSORS
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CoulombFriction, CubicSpring, GapStop, SupportSpring
from fe_models.causes.candidate import Candidate, HarmonicCandidate, LawCandidate
from fe_models.causes.known import Known
from fe_models.causes.places import Motion, places_of
from fe_models.causes.searched import candidates_of
from fe_models.causes.support_spring import PARALLEL_SPRING_WEIGHT
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import Beam, Spring, Structure
from hybrid.diagnosis.contest.growing import fit_growing, passed_by, reference_fits_of, shortened
from hybrid.diagnosis.contest.pairs import asks_for_more
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.contest.stages import Search
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.screening.force_screening import screen_forces
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from tests.frames import beam
from tests.masts import RATE, SENSORS, TUBE, masts, recorded

WHITE = np.random.default_rng(0).standard_normal((1, 200, 5))
CHAIN = Dataset(four_dof(), 10.0, CHAIN_SENSORS, (Recording("r", WHITE),))
STIFF = 5e7  # N/m^3: at 2 cm a seventh as stiff as a mast


def pairs_of(structure: Structure) -> list[Any]:
    """The pairs of nodes between which forces are looked for."""
    rng = np.random.default_rng(0)
    recording = Recording("r", rng.standard_normal((1, 200, len(SENSORS))))
    nominal = nominal_model_of(Dataset(structure, RATE, SENSORS, (recording,)))
    motion = Motion.of_states(rng.standard_normal((50, 2 * nominal.size)), nominal.followed_shapes)
    return [(place.location["nodes"], place.direction) for place in places_of(nominal, motion) if len(place.nodes) == 2]


def force_laws_of(known: Known) -> list[Candidate]:
    return [candidate for candidate in candidates_of(known) if isinstance(candidate, LawCandidate)]


def test_spring_beside_one_to_the_ground_is_less_probable_than_that_one_off() -> None:
    nominal = nominal_model_of(CHAIN)
    motion = Motion(*np.random.default_rng(0).standard_normal((2, 50, 4)))
    springs = SupportSpring.candidates(Known(nominal, motion))
    assert [(c.location["node"], c.weight) for c in springs] == [
        (1, PARALLEL_SPRING_WEIGHT),
        (2, 1.0),
        (3, 1.0),
        (4, 1.0),
    ]


def test_no_force_law_is_looked_for_where_nothing_moves() -> None:
    """A beam whose sensors look across moves along by rounding only, and a stop there would have no gap."""
    rng = np.random.default_rng(0)
    across = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 3, 5))
    structure = beam()
    nominal = nominal_model_of(Dataset(structure, 600.0, across, (Recording("r", rng.standard_normal((1, 200, 3))),)))
    most = {
        word: np.abs(nominal.modes[1][nominal.dofs.direction == word, : nominal.size]).max(axis=0)
        for word in ("x", "y")
    }
    along = most["x"] > most["y"]
    assert along.any()
    states = rng.standard_normal((50, 2, nominal.size)) * np.where(along, 1e-12, 1.0)
    motion = Motion.of_states(states.reshape(50, -1), nominal.followed_shapes)
    known = Known(nominal, motion)
    assert {place.direction for place in known.places} == {"x", "y"}
    laws = force_laws_of(known)
    assert {law.location["direction"] for law in laws} == {"y"}
    still = Motion(np.zeros((50, len(nominal.dofs))), np.zeros((50, len(nominal.dofs))))
    assert force_laws_of(Known(nominal, still)) == []


def test_harmonic_forces_turn_once_in_a_recording_at_least() -> None:
    setting = setting_of(CHAIN)
    forces = tuple(c for c in setting.candidates() if isinstance(c, HarmonicCandidate))
    slowest = 10.0 / setting.lengths.whole[0].samples  # Hz
    assert [c.lower for c in forces] == [(slowest,)] * 4
    base = fit(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths.whole, setting.noise_model
    )
    assert base is not None
    assert min(trial.start[0] for trial in screen_forces(base, forces, setting.noise_model)) >= slowest


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


@pytest.mark.slow
@pytest.mark.parametrize(
    "effect", [GapStop((3, 6), "x", 0.005, 2e5, 1), CoulombFriction((3, 6), "x", 15.0, 1e-3)], ids=lambda e: e.kind
)
def test_masts_that_knock_or_rub_are_detected(effect: GapStop | CoulombFriction) -> None:
    found = diagnose(recorded(masts(), effect))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == (effect.kind, effect.location)
    assert finding.probability > 0.9
    word = "gap" if isinstance(effect, GapStop) else "force"
    value = finding.parameters[word]
    assert value.value == pytest.approx(effect.parameters[word], rel=0.1)  # the contract's bound
    assert found.scores["extended"]["measured"] == pytest.approx(found.noise_floor, rel=0.05)


def test_frame_that_forecasts_well_is_searched_further_where_it_leaves_half_as_much_again_as_noise() -> None:
    setting = setting_of(recorded(masts()))
    ground = reference_fits_of(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths, setting.noise_model
    )
    assert ground is not None
    search = Search(ground, setting.lengths, (), setting.noise_model, setting.noise_model, setting.band, str)
    base = ground.whole
    more = tuple(1.4 * part for part in base.residuals)  # twice the energy
    assert search.is_ample(base)
    assert not search.is_ample(replace(base, residuals=more, chi2=1.96 * base.chi2))


@pytest.mark.parametrize(("rest", "asks"), [(0.75, True), (0.85, False)])
def test_second_cause_is_looked_for_unless_the_first_leaves_most_of_what_is_wrong(rest: float, asks: bool) -> None:
    setting = setting_of(recorded(masts()))
    ground = reference_fits_of(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths, setting.noise_model
    )
    assert ground is not None
    base = ground.whole
    loud = tuple(part + 10 * np.sin(0.3 * np.arange(part.shape[1]))[:, None] for part in base.residuals)  # 5 Hz
    single = replace(base.hypothesis, candidates=setting.candidates()[:1])
    first = replace(base, hypothesis=single, residuals=loud, cost=base.cost - base.misfit + rest * 1e6)
    wrong = replace(base, cost=base.cost - base.misfit + 1e6)
    assert first.misfit == pytest.approx(rest * wrong.misfit)
    assert asks_for_more(first, wrong, setting.noise_model, setting.band) is asks


@pytest.mark.slow
def test_short_segments_begin_where_the_motion_of_whole_recordings_passes() -> None:
    setting = setting_of(recorded(masts(middle=3.0), CubicSpring((3,), "x", 4 * STIFF)))
    place = {"node": 3, "direction": "x"}
    (spring,) = (c for c in setting.candidates() if c.kind == "cubic_spring" and c.location == place)
    hypothesis, noise_model, segments = (
        setting.nominal_hypothesis.adding(spring),
        setting.noise_model,
        setting.lengths.cut[0],
    )
    theta = np.append(setting.nominal_hypothesis.centre, 4 * STIFF)
    whole = fit_growing(hypothesis, theta, setting.lengths, noise_model, setting.short)
    assert whole is not None
    own = fit(hypothesis, whole.theta, segments, noise_model, passed_by(whole, segments, noise_model))
    assert own is not None
    off = (passed_by(whole, segments, noise_model)[0] - own.states[0]) / own.state_errors[0]
    assert np.sqrt(np.mean(off**2)) < 1.5  # of what noise alone makes of the states of a segment

    astray = tuple(-3 * states for states in own.states)
    stuck, found = (
        fit(hypothesis, whole.theta, segments, noise_model, astray),
        shortened(whole, segments, noise_model, astray),
    )
    assert stuck is not None
    assert found is not None
    assert stuck.cost > 10 * own.cost
    assert found.cost == pytest.approx(own.cost, rel=1e-3)
