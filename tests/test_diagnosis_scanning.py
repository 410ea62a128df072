"""Large effects ranked by a scan, weak ones by the score test, both on the bridge; modal forms of linear channels."""

from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from benchmarks.blind_cases import SENSORS as CHAIN_SENSORS
from benchmarks.blind_cases.bridge import SENSORS
from benchmarks.blind_cases.bridge_scene import free_motion
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import AddedMass, Effect, ModalDamping, StiffnessChange, SupportSpring, TimeIntegration
from fe_models.causes.candidate import (
    Candidate,
    MatrixCandidate,
    ModeCandidate,
    SensorCandidate,
    StepCandidate,
    SupportCandidate,
)
from fe_models.causes.places import Motion
from fe_models.causes.stiffness_change import REMAINING_SHARES
from fe_models.modes import natural_modes
from fe_models.recordings import Assumptions, Dataset, Recording
from hybrid.diagnosis.contest.growing import Lengths, ReferenceFits
from hybrid.diagnosis.contest.search import contest
from hybrid.diagnosis.fitting.config import CALIBRATION
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import System, drift, modal_form, observability
from hybrid.diagnosis.screening.confounded_factors import confounded_candidates
from hybrid.diagnosis.screening.scanning import scan, sizes_of, unseen
from hybrid.diagnosis.screening.screening import screen

RATE, SAMPLES, MOVING = 100.0, 100, 10
FITTED = tuple(sensor for sensor in SENSORS if sensor.role == "measured")
NOISE = 0.01  # of each channel's rms


@cache
def bridge_model() -> NominalModel:
    recording = Recording("r", np.ones((1, SAMPLES, len(FITTED))))
    return nominal_model_of(Dataset(bridge(), RATE, FITTED, (recording,), 30.0, Assumptions(modes=MOVING)))


@cache
def linear_candidates() -> tuple[Candidate, ...]:
    """Causes of the matrices; with the laws a test would take several times as long."""
    nominal = bridge_model()
    data = np.random.default_rng(1).standard_normal((1, SAMPLES, len(FITTED)))
    dataset = Dataset(bridge(), RATE, FITTED, (Recording("r", data),), 30.0)
    q = np.random.default_rng(2).standard_normal((2, 10, nominal.size)) / [[nominal.modes[0]], [np.ones(nominal.size)]]
    motion = Motion(q[0] @ nominal.modes[1].T, q[1] @ nominal.modes[1].T)
    found = all_candidates(nominal, dataset, motion, tuple(range(len(FITTED))))
    return tuple(c for c in found if isinstance(c, MatrixCandidate | ModeCandidate | SensorCandidate))


def recorded(effect: Effect, moving: int = MOVING) -> tuple[Fit, NoiseModel]:
    """Return the nominal fit to three short recordings of the bridge with an effect, from its own modes, with noise."""
    rng = np.random.default_rng(3)
    modal = natural_modes(linearise(bridge().with_effects(effect)), moving)
    q, p = rng.standard_normal((2, moving, 3)) / modal.omega[:, None] ** [[[2]], [[1]]]
    motion = free_motion(modal, q, p, np.arange(SAMPLES) / RATE)
    data = np.stack([motion.shown(s) for s in FITTED], axis=-1)
    sigma = NOISE * data.std(axis=(0, 1))
    batch = Batch(data + sigma * rng.standard_normal(data.shape), ("a", "b", "c"))
    noise_model = NoiseModel(FITTED, RATE, sigma)
    nominal = Hypothesis(bridge_model())
    found = fit(nominal, nominal.centre, (batch,), noise_model)
    assert found is not None
    return found, noise_model


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "value"),
    [
        (StiffnessChange((57,), 0.2), 0.2),
        (StiffnessChange((49,), 0.055), 0.055),  # a tower all but broken
        (SupportSpring(7, "y", 3e3), 1 / 3e3),
    ],
    ids=lambda item: getattr(item, "kind", ""),
)
def test_a_large_effect_ranks_first_at_about_its_size(effect: Effect, value: float) -> None:
    found, noise_model = recorded(effect)
    assert found.chi2 > 1.5 * found.values  # the uncertain factors do not make up for it
    kinds = {"stiffness_change", "support_spring", "sensor_gain"}
    best = scan(found, tuple(c for c in linear_candidates() if c.kind in kinds), noise_model)[0]
    assert (best.candidate.kind, best.candidate.location) == (effect.kind, effect.location)
    assert 0.4 < best.start[0] / value < 2.5  # the sizes tried are that far apart


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "value", "tolerance"),
    [
        (AddedMass(12, 0.03), 0.03, 0.05),
        (StiffnessChange((14,), 0.97), 0.97, 0.01),
        (SupportSpring(7, "y", 5e5), 1 / 5e5, 0.1),
    ],
    ids=lambda item: getattr(item, "kind", ""),
)
def test_the_score_test_finds_what_is_weak(effect: Effect, value: float, tolerance: float) -> None:
    found, noise_model = recorded(effect)
    best = screen(found, linear_candidates(), noise_model)[0]
    assert (best.candidate.kind, best.candidate.location) == (effect.kind, effect.location)
    assert best.start[0] == pytest.approx(value, rel=tolerance)  # of first order only, and with noise


@pytest.mark.slow
def test_a_support_that_gives_way_is_scanned_within_a_fifth_of_any_compliance() -> None:
    """A fit that begins a third off may lead astray, and the cause is out of the contest."""
    soft = next(c for c in linear_candidates() if isinstance(c, SupportCandidate))
    sizes = sizes_of(soft)[:, 0]
    wanted = soft.width[0] * np.geomspace(0.006, 20.0, 500)
    nearest = np.abs(np.log(sizes[:, None] / wanted)).min(axis=0)
    assert nearest.max() < np.log(1.2)


def chain_system() -> System:
    """Return the chain with a gain, a delay and a drift in its sensors."""
    nominal = nominal_model_of(Dataset(four_dof(), 10.0, CHAIN_SENSORS, (Recording("r", np.ones((1, 20, 5))),)))
    hypothesis = Hypothesis(nominal)
    plain = system_of(hypothesis, np.zeros((1, hypothesis.nuisances)), SensorOutputs.measured(CHAIN_SENSORS, 10.0))
    gain, delay, slope = np.array([[1.0, 0.7, 1.0, 1.3, 1.0], [0.0, 0.03, -0.25, 0.0, 0.1], [0.0, 0.0, 0.2, 0.0, -0.1]])
    return replace(plain, gain=gain[None], delay=delay[None], slope=slope[None])


def by_exponentials(system: System, start: FloatArray, samples: int) -> FloatArray:
    """Return the channels (recording, time, sensor) by one matrix exponential each."""
    A, C = system.A[0], system.C[0]
    time = system.step * np.arange(samples)
    rows = [
        [g * c @ expm(A * (t - d)) for c, g, d in zip(C, system.gain[0], system.delay[0], strict=True)] for t in time
    ]
    return np.einsum("tsn,rn->rts", np.array(rows), start) + system.slope[0] * time[:, None]


def test_modal_form_is_the_matrix_exponential_with_gain_delay_and_drift() -> None:
    system = chain_system()
    start = np.random.default_rng(4).standard_normal((2, 8))
    assert modal_form(system) is not None
    expected = by_exponentials(system, start, 60)
    np.testing.assert_allclose(respond(system, start[None], 60)[0], expected, atol=1e-11)  # rounding
    seen = observability(system, 60)[0]
    np.testing.assert_allclose(np.einsum("tsn,rn->rts", seen, start) + drift(system, 60)[0], expected, atol=1e-11)


def test_a_body_that_moves_freely_has_no_modal_form_and_still_the_right_channels() -> None:
    held = chain_system()
    A = held.A.copy()
    A[:, 4:] = 0.0
    A[0, 4:, :4] = -np.diag([0.0, 1.0, 2.0, 3.0])  # the first mass is free: it drifts at its own velocity for ever
    system = replace(held, A=A)
    assert modal_form(system) is None
    start = np.random.default_rng(4).standard_normal((2, 8))
    expected = by_exponentials(system, start, 60)
    np.testing.assert_allclose(respond(system, start[None], 60)[0], expected, atol=1e-11)
    assert np.abs(expected).max() > 3  # it has moved


def test_one_defective_variant_does_not_spoil_the_others() -> None:
    good = chain_system()
    bad = good.A.copy()
    bad[:, 4:] = 0.0
    shared: dict[str, Any] = {
        name: np.repeat(getattr(good, name), 2, axis=0) for name in ("B", "C", "D", "G", "gain", "delay", "slope")
    }
    both = replace(good, A=np.concatenate([good.A, bad]), **shared)
    start = np.random.default_rng(4).standard_normal((2, 2, 8))
    found = respond(both, start, 60)
    for number, one in enumerate((good, replace(good, A=bad))):
        np.testing.assert_allclose(found[number], by_exponentials(one, start[number], 60), atol=1e-10)


@pytest.mark.slow
def test_large_loss_is_found_though_the_score_test_is_far_off() -> None:
    base, noise_model = recorded(StiffnessChange((9,), 0.33))
    lost = next(t for t in screen(base, linear_candidates(), noise_model) if t.candidate.location == {"element": 9})
    assert abs(lost.start[0] - 0.33) > 0.2  # to first order
    best, second = contest(ReferenceFits(base, base), linear_candidates(), Lengths((base.batches,)), noise_model)[:2]
    assert best.hypothesis.candidates[-1].key == "stiffness_change {'element': 9}"
    assert best.theta[-1] == pytest.approx(0.33, rel=0.01)  # noise of 1 % in 2100 values, ten frequencies
    assert best.log_evidence > second.log_evidence + 1000


@pytest.mark.slow
@pytest.mark.parametrize(("node", "stiffness"), [(29, 4000.0), (26, 685.0)])  # N/m: the deck itself has 2 and 7 kN/m
def test_a_support_that_gives_way_far_is_found(node: int, stiffness: float) -> None:
    base, noise_model = recorded(SupportSpring(node, "y", stiffness))
    best, second = contest(
        ReferenceFits(base, base), linear_candidates(), Lengths((base.batches,)), noise_model, kept=4
    )[:2]
    assert best.hypothesis.candidates[-1].key == f"support_spring {{'node': {node}, 'direction': 'y'}}"
    assert 1 / best.theta[-1] == pytest.approx(stiffness, rel=0.03)  # noise of 1 % in 2100 values, ten frequencies
    assert best.log_evidence > second.log_evidence + 1000


def test_an_element_that_is_all_but_lost_is_begun_as_such_where_much_is_wrong() -> None:
    found, noise_model = recorded(StiffnessChange((9,), 0.05))
    trials = unseen(found, linear_candidates(), noise_model)
    lost = [trial for trial in trials if not isinstance(trial.candidate, SupportCandidate)]
    elements = sorted(trial.candidate.location["element"] for trial in lost)
    assert elements == list(range(1, len(bridge().elements) + 1))
    assert all(trial.is_drawn and trial.start[0] in REMAINING_SHARES for trial in lost)
    assert (trials[0].candidate.location, trials[0].start) == ({"element": 9}, (0.05,))
    assert unseen(*recorded(AddedMass(12, 1e-4))[:1], linear_candidates(), noise_model) == []  # little is left


def test_supports_that_give_way_and_time_steps_are_begun_where_calibrated_factors_are_far_off() -> None:
    """The steps also where they promise nothing: here the simulation has none that could make an error."""
    base, noise_model = recorded(AddedMass(12, 1e-4))
    astray = replace(base, theta=base.theta + 3 * base.hypothesis.width * (np.arange(len(base.theta)) == 0))
    steps = StepCandidate(
        kind=TimeIntegration.kind,
        location={},
        names=(),
        build=partial(TimeIntegration, 0.01),
        neutral=(),
        width=(),
        lower=(),
    )
    trials = {trial.candidate.key: trial for trial in unseen(astray, (*linear_candidates(), steps), noise_model)}
    begun = trials.pop(steps.key)
    assert begun.is_drawn and begun.gain == 0
    places = [trial.candidate.location for trial in trials.values()]
    assert {(place["node"], place["direction"]) for place in places} == {
        (int(bridge_model().dofs.node[row]), str(bridge_model().dofs.direction[row]))
        for row in np.flatnonzero(~bridge_model().dofs.free)
    }


def test_a_lost_element_brings_the_mode_that_comes_down_into_the_band() -> None:
    effect = StiffnessChange((3,), 0.05)
    there, drawn = (
        natural_modes(linearise(s), MOVING + 1).frequencies for s in (bridge().with_effects(effect), bridge())
    )
    assert there[-1] < 30 < drawn[-1]  # Hz, of the low-pass
    base, noise_model = recorded(effect, moving=MOVING + 1)
    trials = {
        trial.candidate.location.get("element"): trial for trial in unseen(base, linear_candidates(), noise_model)
    }
    assert (trials[3].start, trials[3].candidate.brings) == ((0.05,), 1)
    assert trials[60].candidate.brings == 0  # a cable has no part in a mode that close
    begun = {more: replace(trials[3].candidate, brings=more) for more in (0, 1)}
    left = {}
    for more, candidate in begun.items():
        hypothesis = Hypothesis(bridge_model(), (candidate,))
        found = fit(hypothesis, np.append(np.zeros(hypothesis.nuisances), 0.05), base.batches, noise_model)
        assert found is not None
        left[more] = found.chi2 / found.values
    assert left[1] < 1.05  # nothing but noise, whose mean square of 2100 values is known to 0.03
    assert left[0] > 2 * left[1]


@pytest.mark.slow
def test_a_cause_that_a_calibrated_factor_hides_takes_its_place() -> None:
    """Damping four times as large leaves nothing, the calibration fourteen of its deviations off."""
    base, noise_model = recorded(ModalDamping((3,), 4 * float(bridge_model().own_ratios[2])))
    first = confounded_candidates(base, linear_candidates())[0]
    assert first.candidate.key == "modal_damping {'modes': [3]}"
    assert first.start[0] == pytest.approx(4 * bridge_model().own_ratios[2], rel=0.05)  # noise of 1 % for a second
    tested = next(t for t in screen(base, linear_candidates(), noise_model) if t.candidate.key == first.candidate.key)
    assert tested.gain < 0.2 * first.gain  # to first order the factor does the same, and hides it
    best = contest(ReferenceFits(base, base), linear_candidates(), Lengths((base.batches,)), noise_model, kept=4)[0]
    assert best.hypothesis.candidates[-1].key == first.candidate.key
    assert (
        np.abs(best.theta[: base.hypothesis.nuisances] / base.hypothesis.width).max() < CALIBRATION.max_deviation_sigma
    )
