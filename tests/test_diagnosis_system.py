"""The state space of a diagnosis against Exudyn, Newmark's own steps, and brute-force differences."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import SENSORS, BlindConfig, blind_case
from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import (
    AddedMass,
    CoulombFriction,
    CubicSpring,
    Effect,
    GapStop,
    ModalDamping,
    PointDamper,
    QuadraticDamper,
    QuadraticSpring,
    SlackCable,
    StiffnessChange,
    SupportSpring,
)
from fe_models.causes.candidate import Candidate, LawCandidate
from fe_models.causes.places import Motion
from fe_models.recordings import Assumptions, Dataset, Recording
from fe_models.simulation import FreeConfig, simulate_free
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
from hybrid.diagnosis.response.system import observability
from hybrid.diagnosis.screening.screening import law_responses, screen

RATE, SAMPLES = 10.0, 301
FITTED = tuple(sensor for sensor in SENSORS if sensor.role == "measured")
OUTPUTS = SensorOutputs.measured(FITTED, RATE)
EXACT = Dataset(four_dof(), RATE, SENSORS, (Recording("r", np.random.default_rng(1).standard_normal((1, SAMPLES, 5))),))
START = np.random.default_rng(0).standard_normal((2, 3, 4))  # displacement and velocity of three motions


def candidates(nominal: NominalModel) -> tuple[Candidate, ...]:
    return all_candidates(nominal, EXACT, Motion(START[0], START[1]), (0, 1, 2, 3))


def shown_by_exudyn(*effects: Effect) -> FloatArray:
    config = FreeConfig((SAMPLES - 1) / RATE, RATE, 0.005)
    motion = simulate_free(four_dof().with_effects(*effects), START[0], START[1], config, progress=False)
    return np.stack([motion.shown(s) for s in FITTED], axis=-1)


LINEAR: list[tuple[Effect, list[float]]] = [
    (StiffnessChange((2,), 0.6), [0.6]),
    (AddedMass(3, 0.7), [0.7]),
    (SupportSpring(4, "x", 0.3), [0.3]),
    (PointDamper((2, 3), "x", 0.2), [0.2]),
    (ModalDamping((2,), 0.08), [0.08]),
]
LAWS: list[tuple[Effect, list[float], float]] = [  # the last number: largest error over the largest value
    (CubicSpring((1,), "x", 0.5), [0.5], 2e-4),
    (QuadraticDamper((3, 4), "x", 0.3), [0.3], 2e-4),
    (QuadraticSpring((2, 3), "x", 0.3), [0.3], 2e-4),
    (GapStop((2,), "x", 0.5, 2.0, 1), [2.0, 0.5], 5e-3),  # its stiffness jumps between samples
    (SlackCable(3, 0.8), [0.8], 5e-3),
]


def chosen(nominal: NominalModel, effect: Effect) -> Candidate:
    found = [c for c in candidates(nominal) if c.kind == effect.kind and effect.location.items() <= c.location.items()]
    if isinstance(effect, GapStop):
        found = [c for c in found if c.location["side"] == effect.side]
    (candidate,) = found
    return candidate


def shown_here(effect: Effect, values: list[float]) -> FloatArray:
    nominal = nominal_model_of(EXACT)
    hypothesis = Hypothesis(nominal, (chosen(nominal, effect),))
    theta = np.array([[0.0] * hypothesis.nuisances + values])
    system = system_of(hypothesis, theta, OUTPUTS)
    return respond(system, np.concatenate([START[0], START[1]], axis=1)[None], SAMPLES)[0]


@pytest.mark.parametrize(("effect", "values"), LINEAR, ids=lambda item: getattr(item, "kind", ""))
def test_linear_causes_move_as_in_exudyn(effect: Effect, values: list[float]) -> None:
    truth = shown_by_exudyn(effect)
    assert np.abs(shown_here(effect, values) - truth).max() < 1e-6 * np.abs(truth).max()  # both nearly exact


@pytest.mark.parametrize(("effect", "values", "error"), LAWS, ids=lambda item: getattr(item, "kind", ""))
def test_force_laws_move_as_in_exudyn(effect: Effect, values: list[float], error: float) -> None:
    truth = shown_by_exudyn(effect)
    assert np.abs(truth - shown_by_exudyn()).max() > 0.1 * np.abs(truth).max()  # the law is felt
    assert np.abs(shown_here(effect, values) - truth).max() < error * np.abs(truth).max()


def test_friction_moves_as_in_exudyn_but_for_its_creep() -> None:
    effect = CoulombFriction((1,), "x", 0.1, 0.01)
    truth = shown_by_exudyn(effect)
    assert np.abs(shown_here(effect, [0.1])[..., 0] - truth[..., 0]).max() < 0.02 * np.abs(truth[..., 0]).max()


def test_the_users_own_newmark_steps_are_shown() -> None:
    dataset = replace(EXACT, assumptions=Assumptions(integrator="newmark", step=0.1))
    nominal = nominal_model_of(dataset)
    hypothesis = Hypothesis(nominal)
    system = system_of(hypothesis, np.zeros((1, hypothesis.nuisances)), OUTPUTS)
    drawn = Hypothesis(nominal_model_of(EXACT))
    exact = system_of(drawn, np.zeros((1, drawn.nuisances)), OUTPUTS)
    half = 0.05 * exact.A[0]
    step = np.linalg.solve(np.eye(8) - half, np.eye(8) + half)  # the trapezoidal rule
    expected = exact.C[0] @ np.linalg.matrix_power(step, 100)
    assert np.allclose(observability(system, 101)[0, 100], expected, atol=1e-10)  # rounding
    assert not np.allclose(observability(exact, 101)[0, 100], expected, atol=1e-2)


@pytest.fixture(scope="module")
def weak() -> tuple[Fit, NoiseModel, tuple[Candidate, ...]]:
    """The nominal fit to a motion without noise in which a cubic spring is barely felt."""
    data = shown_by_exudyn(CubicSpring((1,), "x", 1e-3))
    noise_model = NoiseModel(FITTED, RATE, np.full(4, 1e-3))
    nominal = nominal_model_of(EXACT)
    hypothesis = Hypothesis(nominal)
    found = fit(hypothesis, hypothesis.centre, (Batch(data, ("a", "b", "c")).cut(60),), noise_model)
    assert found is not None
    return found, noise_model, candidates(nominal)


def test_score_test_finds_kind_place_and_size(weak: tuple[Fit, NoiseModel, tuple[Candidate, ...]]) -> None:
    found, noise_model, all_of_them = weak
    best = screen(found, all_of_them, noise_model)[0]
    assert (best.candidate.kind, best.candidate.location) == ("cubic_spring", {"node": 1, "direction": "x"})
    assert best.start[0] == pytest.approx(1e-3, rel=0.05)  # of first order only


def test_score_test_promises_what_a_fit_keeps(weak: tuple[Fit, NoiseModel, tuple[Candidate, ...]]) -> None:
    found, noise_model, all_of_them = weak
    best = screen(found, all_of_them, noise_model)[0]
    refined = fit(
        found.hypothesis.adding(best.candidate),
        np.append(found.theta, best.start),
        found.batches,
        noise_model,
        found.states,
    )
    assert refined is not None
    assert found.cost - refined.cost == pytest.approx(best.gain, rel=0.05)


def test_responses_of_laws_equal_differences(weak: tuple[Fit, NoiseModel, tuple[Candidate, ...]]) -> None:
    found, noise_model, all_of_them = weak
    laws = [
        c
        for c in all_of_them
        if isinstance(c, LawCandidate) and c.kind != "slack_cable" and c.location.get("node") == 1
    ]
    responses = law_responses(found, laws, noise_model)
    assert len(laws) == 6
    z = found.states[0]
    for law in laws:
        shown = []
        for candidate, values in ((None, ()), (law, law.first_starts[0])):
            hypothesis = found.hypothesis if candidate is None else found.hypothesis.adding(candidate)
            system = system_of(hypothesis, np.append(found.theta, values)[None], noise_model.outputs)
            shown.append(respond(system, z[None], 60)[0] / noise_model.sigma)
        difference = (shown[1] - shown[0]).reshape(len(z), -1)
        error = np.abs(responses[law.key][0][0] - difference).max() / np.abs(difference).max()
        assert error < 0.06, law.key  # friction and contacts are steep; the steps are of first order


def test_fit_returns_hidden_factors() -> None:
    case = blind_case(5, BlindConfig(("stiffness_change",), noise=0.0, train=3, test=1, duration=20.0))
    nominal = nominal_model_of(case.dataset)
    (cause,) = case.truth
    assert isinstance(cause, StiffnessChange)
    hypothesis = Hypothesis(nominal, (chosen(nominal, cause),))
    data = np.concatenate([recording.data[..., :4] for recording in case.dataset.select("train")])
    noise_model = NoiseModel(FITTED, RATE, 1e-4 * np.ones(4))  # small enough for the prior to have no say
    found = fit(hypothesis, hypothesis.centre, (Batch(data, ("a", "b", "c")).cut(60),), noise_model, iterations=30)
    assert found is not None
    # 0.01 sqrt(ENOUGH), from the factor it resembles
    assert found.theta[-1] == pytest.approx(cause.parameters["factor"], abs=3e-3)
    assert np.abs(found.theta[:-1]).max() < 1e-3
