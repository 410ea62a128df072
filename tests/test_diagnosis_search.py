"""The search: slopes of law fits, harmonic forces, causes that come and go, two causes at once."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from benchmarks.blind.judging import judge
from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.arrays import FloatArray
from fe_models.causes import CubicSpring, HarmonicForce
from fe_models.causes.candidate import Candidate
from hybrid.diagnosis.contest.growing import fit_growing, lengths_of, padded, reference_fits_of
from hybrid.diagnosis.contest.odds import Odds
from hybrid.diagnosis.contest.pairs import asks_for_more, each_alone
from hybrid.diagnosis.contest.posterior import posterior_of
from hybrid.diagnosis.contest.recording_groups import asked_for
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.contest.shortlist import foremost, most_promising_of_each_kind, promising
from hybrid.diagnosis.contest.switching import acting_recordings, fit_switched
from hybrid.diagnosis.fitting import linearisation
from hybrid.diagnosis.fitting.calibration_deviation import farthest_of
from hybrid.diagnosis.fitting.driven import states_along
from hybrid.diagnosis.fitting.harmonic_amplitude import harmonic_amplitude
from hybrid.diagnosis.fitting.least_squares import Step, fit
from hybrid.diagnosis.fitting.linearisation import linearise_batch
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.loads import Loads
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.system import System
from hybrid.diagnosis.screening.screening import Screened
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from tests.chain_fits import MEASURED, MOTION, candidate, gauge_of, nominal_fit


def test_harmonic_force_has_its_amplitude_where_it_acts() -> None:
    case = blind_case(7, BlindConfig(("harmonic_force",), size=0.6, train=6, test=1, duration=30.0, changed=2))
    (cause,) = case.truth
    assert isinstance(cause, HarmonicForce)
    batches, noise_model = gauge_of(case.dataset)
    hypothesis = Hypothesis(
        nominal_model_of(case.dataset), (candidate(case.dataset, "harmonic_force", node=cause.node),)
    )
    found = fit(hypothesis, np.append(np.zeros(hypothesis.nuisances), cause.frequency + 0.003), batches, noise_model)
    assert found is not None
    seen = harmonic_amplitude(found, 0)
    assert list(seen.acting) == [False, False, True, True, True, True]
    assert seen.amplitude == pytest.approx(cause.amplitude, abs=3 * seen.error)
    assert seen.error < 0.1 * cause.amplitude
    assert acting_recordings(found, 0) == case.recordings[:4]


def test_harmonic_force_that_nothing_distinguishes_from_none_is_no_hypothesis() -> None:
    case = blind_case(7, BlindConfig(("harmonic_force",), size=0.6, train=3, test=1, duration=30.0))
    (cause,) = case.truth
    assert isinstance(cause, HarmonicForce)
    batches, noise_model = gauge_of(case.dataset)
    base = nominal_fit(case.dataset, batches, noise_model)
    place, other = (candidate(case.dataset, "harmonic_force", node=cause.node + i) for i in (0, 1))
    right = fit(base.hypothesis.adding(place), np.append(base.theta, cause.frequency), batches, noise_model)
    assert right is not None
    more = right.hypothesis.adding(other)
    both = fit(more, np.append(right.theta, 0.02), batches, noise_model, padded(right, more))  # Hz, below all modes
    assert both is not None
    assert [harmonic_amplitude(both, number).is_significant for number in (0, 1)] == [True, False]
    better = replace(both, cost=right.cost - 1000.0)  # as where it pushes a law to and fro
    assert better.log_evidence > right.log_evidence
    assert posterior_of((base, right, better), (place, other)).fits == (right, base)


@pytest.mark.parametrize("kind", ["cubic_spring", "gap_stop"])
def test_slopes_behind_a_low_pass_need_no_finer_motion(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    case = blind_case(2, BlindConfig((kind,), size=1.0, train=2, test=1, duration=30.0))
    (cause,) = case.truth
    dataset = replace(case.dataset, lowpass=3.0)  # Hz, of 5 that are sampled
    batches, noise_model = gauge_of(dataset)
    base = nominal_fit(dataset, batches, noise_model)
    law = candidate(dataset, kind, **cause.location)
    extended = base.hypothesis.adding(law)
    theta = np.append(base.theta, [cause.parameters[name] for name in law.names])
    near = extended, theta, batches[0], noise_model, padded(base, extended)[0]
    usual = linearise_batch(*near)

    def finely(system: System, start: FloatArray, samples: int, loads: Loads | None = None, **_: int) -> FloatArray:
        return respond(system, start, samples, loads, oversampling=8)

    monkeypatch.setattr(linearisation, "respond", finely)
    finer = linearise_batch(*near)
    assert usual is not None
    assert finer is not None
    # A hundredth of a step is then left to the next one; measured: 0.004 and 0.009.
    assert np.linalg.norm(usual.slopes - finer.slopes) < 0.01 * np.linalg.norm(finer.slopes)


def test_drift_goes_on_from_segment_to_segment() -> None:
    case = blind_case(5, BlindConfig(("sensor_drift",), size=0.8, train=3, test=1, duration=30.0))
    (cause,) = case.truth
    batches, noise_model = gauge_of(case.dataset)
    hypothesis = Hypothesis(
        nominal_model_of(case.dataset), (candidate(case.dataset, "sensor_drift", **cause.location),)
    )
    short = lengths_of(batches, hypothesis.states).cut[0]
    assert short[0].pieces > 1
    found = fit(hypothesis, hypothesis.centre, short, noise_model)
    assert found is not None
    slope, std = found.theta[-1], np.sqrt(found.covariance[-1, -1])
    assert slope == pytest.approx(cause.parameters["slope"], abs=4 * std)
    assert std < 0.05 * abs(slope)  # a slope within segments alone would be known ten times less well


def test_force_law_that_comes_is_found_in_its_recordings() -> None:
    case = blind_case(12, BlindConfig(("cubic_spring",), size=0.8, train=6, test=1, duration=25.0, changed=3))
    (cause,) = case.truth
    assert isinstance(cause, CubicSpring)
    batches, noise_model = gauge_of(case.dataset)
    base = nominal_fit(case.dataset, batches, noise_model)
    lengths = lengths_of(batches, base.hypothesis.states)
    short = nominal_fit(case.dataset, lengths.cut[0], noise_model)
    right = candidate(case.dataset, "cubic_spring", **cause.location)
    wrong = candidate(case.dataset, "added_mass", node=2)
    asked = asked_for(short, (right, wrong), noise_model)
    best = max(fit_switched(short, base, asked, lengths, noise_model), key=lambda item: item.log_evidence)
    assert best.hypothesis.candidates[-1].key == right.key
    assert acting_recordings(best, 0) == case.recordings[:3]
    assert best.theta[-1] == pytest.approx(cause.stiffness, rel=0.1)


def test_nothing_comes_where_recordings_hardly_ask_for_amounts_of_their_own() -> None:
    """A stiffness that drifts in each of them: sorting the recordings by force laws would take longest."""
    setting = setting_of(blind_case(75501, BlindConfig(("drifting_stiffness",), tier="off")).dataset)
    nominal, noise_model, lengths = setting.nominal_hypothesis, setting.searched, setting.lengths
    ground = reference_fits_of(nominal, nominal.centre, lengths, noise_model, setting.short)
    assert ground is not None
    asked = asked_for(ground.short, setting.candidates(), noise_model)
    assert max(item.gain for item in asked) < 0.2 * ground.short.misfit  # measured: 0.15; of what comes, 0.25 to 1
    assert fit_switched(ground.short, ground.whole, asked, lengths, noise_model) == []


def test_one_hypothesis_reached_twice_counts_once() -> None:
    dataset = blind_case(3, BlindConfig(train=2, test=1, duration=15.0)).dataset
    base = nominal_fit(dataset, *gauge_of(dataset))
    found = posterior_of((base, base), all_candidates(nominal_model_of(dataset), dataset, MOTION, MEASURED))
    assert len(found.fits) == 1
    assert found.probability[0] == 1.0


def test_place_that_is_less_probable_beforehand_is_so_afterwards() -> None:
    dataset = blind_case(3, BlindConfig(train=2, test=1, duration=15.0)).dataset
    batches, noise_model = gauge_of(dataset)
    usual = candidate(dataset, "added_mass", node=2)
    hypothesis = Hypothesis(nominal_model_of(dataset), (usual,))
    found = fit(hypothesis, hypothesis.centre, batches, noise_model)
    assert found is not None
    rare = replace(usual, location={"node": 9}, weight=0.1)  # as good in every other way
    other = replace(found, hypothesis=replace(found.hypothesis, candidates=(rare,)))
    none = nominal_fit(dataset, batches, noise_model)
    posterior = posterior_of((other, found, none), (usual, rare), is_astray=True)  # values as uncertain as stated
    known = {id(item): p for item, p in zip(posterior.fits, posterior.probability, strict=True)}
    assert known[id(other)] / known[id(found)] == pytest.approx(0.1)
    weighed = np.exp((found.log_evidence - none.log_evidence) / posterior.temper)
    assert known[id(found)] / known[id(none)] == pytest.approx(0.5 / 1.1 * weighed)  # a half, shared by 1 + 0.1 places


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kinds", "seed"), [(("sensor_gain", "stiffness_change"), 9001), (("harmonic_force", "stiffness_change"), 9300)]
)
def test_two_causes_are_both_named(kinds: tuple[str, ...], seed: int) -> None:
    case = blind_case(seed, BlindConfig(kinds, tier="off", train=6, test=2, duration=30.0))
    marks = judge(case, diagnose(case.dataset))
    assert set(marks.named) == set(marks.truth)


@pytest.mark.slow
def test_what_is_rare_is_found_though_segments_hide_it() -> None:
    """A stop that is hit now and then beside a late sensor, which is the only one of them that a few seconds show."""
    case = blind_case(54017, BlindConfig(("sensor_delay", "gap_stop")))
    marks = judge(case, diagnose(case.dataset))
    assert set(marks.named) == set(marks.truth)


@pytest.mark.slow
def test_stiffness_is_known_no_better_than_its_uncertainty_allows() -> None:
    case = blind_case(33016, BlindConfig(("coulomb_friction", "stiffness_change"), tier="off"))
    setting = setting_of(case.dataset)
    friction = candidate(case.dataset, "coulomb_friction", node=1)
    factor = candidate(case.dataset, "stiffness_change", element=2)
    hypothesis = Hypothesis(setting.nominal, (friction, factor))
    begun = np.concatenate([np.zeros(hypothesis.nuisances), [0.15, friction.neutral[1], 0.5]])
    found = fit_growing(hypothesis, begun, setting.lengths, setting.searched, setting.short)
    assert found is not None
    # The calibrated stiffness of the element, uncertain by 1 %, does the same as the factor.
    assert np.sqrt(found.covariance[-1, -1]) > 0.99 * 0.01 * found.theta[-1]
    assert found.theta[-1] == pytest.approx(0.474, abs=3 * 0.01 * 0.474)


@pytest.mark.slow
def test_cable_that_is_slack_most_of_the_time_is_named_alone() -> None:
    case = blind_case(90016, BlindConfig(("slack_cable",), tier="off"))
    marks = judge(case, diagnose(case.dataset))
    assert marks.named == marks.truth


@pytest.mark.slow
def test_second_cause_is_asked_for_on_a_frame_where_one_leaves_noise_but_a_calibration_gone_astray() -> None:
    config = BlindConfig(structure="bridge", rich=False, train=2, test=1, duration=4.0)
    setting = setting_of(blind_case(0, config).dataset)
    base = setting.short
    cause = next(c for c in setting.candidates() if c.kind == "added_mass")
    hypothesis = base.hypothesis.adding(cause)
    item = fit(hypothesis, np.append(base.theta, cause.neutral), base.batches, setting.noise_model, base.states)
    assert item is not None
    wrong = replace(base, cost=base.cost + 1e6)
    assert len(item.deviations) == 42
    assert 42 * 2 * norm.sf(farthest_of(42)) == pytest.approx(1 / 200)  # 3.85
    for deviation, asks in ((0.0, False), (3.7, False), (4.0, True)):
        off = replace(item, theta=np.concatenate([[deviation * hypothesis.width[0]], item.theta[1:]]))
        assert asks_for_more(off, wrong, setting.noise_model, setting.band) == asks
        change = replace(off, batches=(replace(off.batches[0], off=(0,)),))  # the cause is all that changed
        assert not asks_for_more(change, wrong, setting.noise_model, setting.band)
    (part,) = item.residuals
    left = 2 * np.sin(0.3 * np.arange(part.shape[1]))[:, None]  # 5 Hz, which is in the structure's band
    wanting = replace(item, residuals=(part + left,))
    worse = replace(item, cost=item.cost + 1e8)
    # little beside that, and yet not noise alone
    assert asks_for_more(wanting, worse, setting.noise_model, setting.band)


def test_each_of_two_causes_is_tried_alone() -> None:
    case = blind_case(33021, BlindConfig(("cubic_spring",), size=0.6, train=4, test=1, duration=30.0))
    (cause,) = case.truth
    setting = setting_of(case.dataset)
    force = candidate(case.dataset, "harmonic_force", node=2)
    spring = candidate(case.dataset, "cubic_spring", **cause.location)
    pair = Hypothesis(setting.nominal, (force, spring))
    start = np.concatenate([np.zeros(pair.nuisances), [0.3, cause.parameters["stiffness"]]])
    states = padded(setting.short, pair)
    both = fit(pair, start, setting.lengths.cut[0], setting.searched, states)
    assert both is not None
    alone = {item.hypothesis.candidates[0].key: item for item in each_alone(both, setting.searched)}
    assert alone[spring.key].chi2 < 1.05 * both.chi2  # the force only takes up noise: two numbers in each segment
    assert alone[spring.key].log_evidence > both.log_evidence
    assert alone[force.key].chi2 > 1.5 * both.chi2  # the spring, nearly half of what is left, is missing


def test_motions_are_sized_between_the_beginnings_of_segments_too() -> None:
    case = blind_case(33021, BlindConfig(train=4, test=1, duration=30.0))
    setting = setting_of(case.dataset)
    (number,) = (i for i, sensor in enumerate(setting.noise_model.sensors) if sensor.quantity == "displacement")
    recorded = [batch.recorded for batch in setting.lengths.whole]
    shown = max(float(np.abs(part[..., number]).max()) for part in recorded)
    along, begun = (
        float(np.abs(states[:, setting.noise_model.sensors[number].node - 1]).max())
        for states in (states_along(setting.short, setting.searched), np.concatenate(setting.short.states))
    )
    assert along == pytest.approx(shown, rel=0.1)  # noise of 3 % of the rms in each value
    assert begun < 0.9 * shown  # so the test can tell the two apart


def begun(cause: Candidate, **marks: bool) -> Screened:
    """Return a trial of a cause, as far as what becomes of its first steps depends on that."""
    return Screened(cause, (1.0,), 1.0, np.zeros(1), **marks)


def test_one_kind_of_law_does_not_crowd_out_the_others() -> None:
    dataset = blind_case(33021, BlindConfig()).dataset
    nominal = nominal_model_of(dataset)
    nodes = (1, 2, 3, 4)
    cubic, drag = (
        [candidate(dataset, kind, node=node) for node in nodes] for kind in ("cubic_spring", "quadratic_damper")
    )
    laws = [*cubic, *drag, candidate(dataset, "gap_stop", node=2)]
    steps = [(begun(law), Step(Hypothesis(nominal, (law,)), np.zeros(1), (), float(i))) for i, law in enumerate(laws)]
    kept = [step.hypothesis.candidates[0].key for step in foremost(steps, Odds.among(laws, 1.0))]
    assert kept == [law.key for law in (*cubic[:2], *drag[:2], laws[-1])]


def test_kind_that_has_but_improbable_places_is_as_improbable() -> None:
    dataset = blind_case(33021, BlindConfig()).dataset
    mass, spring = candidate(dataset, "added_mass", node=2), candidate(dataset, "support_spring", node=2)
    alone = Odds.among((mass, replace(spring, weight=0.1)), alike=1.0)
    assert np.isclose(alone.log(mass), np.log(1 / 2))
    assert np.isclose(alone.log(replace(spring, weight=0.1)), np.log(0.1 / 2))
    beside = Odds.among((mass, spring, replace(spring, weight=0.1)), alike=1.0)
    assert np.isclose(beside.log(spring), np.log(1 / 1.1 / 2))  # shared among its places, as before


@pytest.mark.parametrize("more", [10.0, 30.0])
def test_of_causes_that_promise_nearly_the_same_both_go_on(more: float) -> None:
    dataset = blind_case(33021, BlindConfig()).dataset
    nominal = nominal_model_of(dataset)
    rare, usual = (candidate(dataset, "added_mass", node=node) for node in (2, 4))
    rare = replace(rare, weight=0.1)
    odds = Odds.among((rare, usual), alike=4.0)  # four values tell as much as one: log(10) is worth 2 x 4 x 2.3 = 18
    gains = ((rare, 50.0 + more), (usual, 50.0))
    trials = [Screened(item, (1.0,), gain, np.zeros(nominal.values)) for item, gain in gains]
    assert len(promising([trials], [], 1, odds)) == 2  # 8 and 12 apart: whole recordings may decide


def test_beside_a_law_of_each_kind_the_most_promising_go_on() -> None:
    dataset = blind_case(33021, BlindConfig()).dataset
    still = np.zeros(nominal_model_of(dataset).values)
    mass, stiff = candidate(dataset, "added_mass", node=2), candidate(dataset, "stiffness_change", element=3)
    few = [Screened(mass, (1.0,), gain, still) for gain in (3.0, 1.0)]
    many = [Screened(stiff, (1.0,), float(gain), still, leads=gain == 5) for gain in range(20)]
    kept = most_promising_of_each_kind([*few, *many])
    assert [trial.gain for trial in kept if trial.candidate is mass] == [3.0, 1.0]
    assert [trial.gain for trial in kept if trial.candidate is stiff] == [5.0, 19.0, 18.0, 17.0, 16.0, 15.0, 14.0, 13.0]


def test_twice_as_many_go_on_of_those_that_are_ranked_by_their_modes() -> None:
    dataset = blind_case(33021, BlindConfig()).dataset
    nuisances = np.zeros(nominal_model_of(dataset).values)
    causes = [candidate(dataset, "stiffness_change", element=element) for element in (1, 2, 3, 4)]
    gains = 1e4 * np.arange(4, 0, -1)  # far apart: none goes on for being near another
    by_modes, tested = (
        [Screened(item, (0.9,), gain, nuisances, is_drawn=drawn) for item, gain in zip(causes, gains, strict=True)]
        for drawn in (True, False)
    )
    odds = Odds.among(causes, alike=4.0)
    kept = [trial.is_drawn for trial in promising([tested, by_modes], [], 2, odds)]
    assert kept.count(False) == 2
    assert kept.count(True) == 4
