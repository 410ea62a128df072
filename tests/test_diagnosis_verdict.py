"""When forecasts count as being at the noise floor, and when as near it; what only they show."""

from dataclasses import replace

import numpy as np
import pytest

import fe_models as fe
from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.causes.candidate import Candidate
from fe_models.recordings import Assumptions, Sensor
from hybrid.diagnosis.contest.growing import fit_growing
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.outcome.verdict import Errors, Verdict, verdict_of
from hybrid.diagnosis.report import FORECAST_WITHIN_TOLERANCE, headline
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from tests.frames import beam, vibrations


@pytest.mark.parametrize(
    ("calibrated", "extended", "nothing", "reached"),
    [
        (1.04, 1.0, True, True),  # both within 5 % of the floor, and less than that apart
        (1.04, 0.98, False, True),  # a cause improves on it by more
        (1.20, 1.04, False, True),
        (1.20, 1.10, False, False),
    ],
)
def test_floor_is_reached_within_five_per_cent(
    calibrated: float, extended: float, nothing: bool, reached: bool
) -> None:
    errors = Errors(calibrated, extended, 1.0, 0.0)
    assert (errors.nothing_to_gain, errors.reached) == (nothing, reached)


@pytest.mark.slow
def test_the_users_tolerance_says_what_matters() -> None:
    """A weak hardening spring adds a quarter to the error of forecasts: named, unless three times the floor will do."""
    truth = fe.four_dof().with_effects(fe.CubicSpring((1,), "x", 0.02))
    simulated = fe.simulate(truth, ["x4", "a1", "a3", "a4"], motions=3, duration=40.0, sampling_rate=10.0, noise=0.03)
    dataset = simulated.split(0.7).with_model(fe.four_dof())
    assert [finding.cause.kind for finding in diagnose(dataset).findings] == ["cubic_spring"]
    coarse = diagnose(replace(dataset, assumptions=Assumptions(tolerance=2.0)))
    assert coarse.verdict is Verdict.NOTHING_WRONG
    assert any(note.startswith("significant, but too weak to matter for forecasts: A cubic") for note in coarse.notes)
    assert headline(coarse).endswith(f"forecasts {FORECAST_WITHIN_TOLERANCE.format(tolerance=2.0)}.")


@pytest.mark.parametrize(("extended", "near"), [(1.1, True), (1.2, False)])
def test_near_the_floor_is_within_fifteen_per_cent(extended: float, near: bool) -> None:
    assert Errors(3.0, extended, 1.0, 0.01).near is near


@pytest.mark.slow
@pytest.mark.parametrize(("kinds", "words"), [((), "show nothing"), (("sensor_gain",), "show nothing more")])
def test_what_only_test_recordings_feel_is_reported(kinds: tuple[str, ...], words: str) -> None:
    config = BlindConfig(kinds, size=0.8, train=4, test=2, duration=25.0)
    trained = blind_case(31, config).dataset
    tested = blind_case(31, replace(config, kinds=(*kinds, "cubic_spring"))).dataset
    last = tested.recordings[-1]  # one of the two for testing
    found = diagnose(replace(trained, recordings=(*trained.recordings[:-1], last)))
    assert tuple(finding.cause.kind for finding in found.findings) == kinds
    assert [f"{words} wrong, but test recordings do ({last.name})" in note for note in found.notes].count(True) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("recordings", "samples", "sensors"), [(1, 501, 2), (2, 200, 2), (2, 501, 4)])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_nothing_is_wrong_with_an_exact_model_of_few_recordings(
    recordings: int, samples: int, sensors: int, seed: int
) -> None:
    """Some entry of one or two initial states happens to be next to nothing: that of another recording need not be."""
    case = blind_case(seed, BlindConfig((), train=recordings, test=0)).dataset
    columns = [i for i, sensor in enumerate(case.sensors) if sensor.role == "measured"][:sensors]
    few = replace(
        case,
        sensors=tuple(case.sensors[i] for i in columns),
        recordings=tuple(replace(r, data=r.data[:, :samples, columns]) for r in case.recordings),
    )
    assert diagnose(few).verdict is Verdict.NOTHING_WRONG


def test_calibration_astray_may_stand_for_weak_causes_that_are_known() -> None:
    setting = setting_of(
        blind_case(31, BlindConfig(("sensor_gain",), size=0.8, train=4, test=2, duration=25.0)).dataset
    )
    gain, damping, mass = (
        next(
            c
            for c in setting.candidates()
            if c.kind == kind and c.location in ({"sensor": "a1"}, {"modes": [4]}, {"node": 1})
        )
        for kind in ("sensor_gain", "modal_damping", "added_mass")
    )

    def fitted(*candidates: Candidate) -> Fit:
        hypothesis = Hypothesis(setting.nominal, candidates)
        found = fit_growing(hypothesis, hypothesis.centre, setting.lengths, setting.noise_model, setting.short)
        assert found is not None
        return found

    def astray(item: Fit) -> Fit:
        off = np.zeros_like(item.theta)
        last = item.hypothesis.nominal.factors - 1
        off[last] = 5 * item.hypothesis.width[last]
        return replace(item, theta=item.theta + off)

    def verdict(best: Fit, all_causes: Fit, extended: float = 1.0, unexplained: float = 0.0) -> Verdict:
        errors = Errors(3.0, extended, 1.0, unexplained)
        return verdict_of(best, all_causes, base, setting.noise_model, setting.band, errors)[0]

    base, one, both = fitted(), fitted(gain), fitted(gain, damping)
    assert verdict(one, one) is Verdict.EXPLAINED  # forecasts are at the noise floor
    assert verdict(one, one, 1.3, 0.02) is Verdict.EXPLAINED  # nothing is left to fit, and as good as all is explained
    assert verdict(one, one, 1.3, 0.05) is Verdict.PARTLY_EXPLAINED
    assert verdict(astray(one), one, 2.9, 0.05) is Verdict.PARTLY_EXPLAINED
    assert verdict(astray(one), one, 3.1, 0.05) is Verdict.UNEXPLAINED  # worse than without it
    assert verdict(base, base, 1.3, 0.02) is Verdict.UNEXPLAINED
    assert verdict(astray(one), one) is Verdict.PARTLY_EXPLAINED
    assert verdict(astray(one), both) is Verdict.EXPLAINED
    assert verdict(astray(one), astray(both)) is Verdict.PARTLY_EXPLAINED
    assert verdict(astray(one), fitted(mass, damping)) is Verdict.PARTLY_EXPLAINED  # which has not what is named


@pytest.mark.slow
@pytest.mark.parametrize(("other", "listed"), [(3, VERDICT.listed), (4, 1.0)])
def test_a_weak_cause_next_to_the_one_named_makes_it_less_sure(other: int, listed: float) -> None:
    """A hysteretic spring that hardly yields is a spring, and a little beside it that no forecast needs."""
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    masses = {c.location["node"]: c for c in setting.candidates() if c.kind == "added_mass"}

    def with_masses(*nodes: int) -> Fit:
        hypothesis = Hypothesis(setting.nominal, tuple(masses[node] for node in nodes))
        return replace(setting.short, hypothesis=hypothesis, theta=hypothesis.centre)

    errors, fits = Errors(3.0, 1.0, 1.0, 0.0), (with_masses(2), with_masses(2, other), with_masses())
    assert verdict_of(*fits, setting.noise_model, setting.band, errors) == (Verdict.EXPLAINED, listed)


@pytest.mark.slow
@pytest.mark.parametrize(("by_chance", "found"), [(True, Verdict.NOTHING_WRONG), (False, Verdict.UNEXPLAINED)])
def test_errors_that_initial_states_may_make_by_chance_are_nothing_wrong(by_chance: bool, found: Verdict) -> None:
    sensors = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (2, 4, 5))
    setting = setting_of(vibrations(beam(), beam(), sensors, 3))
    errors = Errors(1.3, 1.3, 1.0, 0.02, by_chance=by_chance)  # times the floor
    base = setting.short
    assert verdict_of(base, base, base, setting.noise_model, setting.band, errors)[0] is found
