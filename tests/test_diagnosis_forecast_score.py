"""Initial states from the first part of a recording: as an independent optimiser finds them; models less a cause."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import norm
from scipy.stats import t as student

from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring, Effect, GapStop
from fe_models.causes.places import Motion
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.diagnosis.fitting.config import FORECAST
from hybrid.diagnosis.fitting.forecast_score import (
    ForecastModel,
    forecast,
    idle_by_order,
    model_of,
    predicted,
    shown_of,
    without,
)
from hybrid.diagnosis.fitting.initial_states import initial_states, precision_of
from hybrid.diagnosis.fitting.least_squares import fit, residuals_at
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.batches import Batch, batches_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel, SensorRoles
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from tests.masts import masts, recorded

NOISE = 0.03
SENSORS = tuple(Sensor(f"x{node}", node, "x", "displacement", "m") for node in (1, 3, 4))
MEASURED = tuple(range(len(SENSORS)))
NOISE_MODEL = NoiseModel(SENSORS, 10.0, np.full(len(SENSORS), NOISE))
VIEW = SensorRoles(SENSORS, MEASURED, NOISE_MODEL)


def chain(*effects: Effect, size: float = 1.0) -> Dataset:
    """Return free motions of a chain with effects, 200 samples each, its initial states ``size`` m and m/s large."""
    rng = np.random.default_rng(2)
    position, velocity = size * rng.standard_normal((2, 3, 4))
    config = FreeConfig(duration=20.0, sampling_rate=10.0)
    motion = simulate_free(four_dof().with_effects(*effects), position, velocity, config, progress=False)
    data = np.stack([motion.shown(s) for s in SENSORS], axis=-1)
    data = data + NOISE * rng.standard_normal(data.shape)
    return Dataset(four_dof(), 10.0, SENSORS, tuple(Recording(f"r{i}", part[None]) for i, part in enumerate(data)))


def with_causes(dataset: Dataset, *keys: str) -> Hypothesis:
    candidates = all_candidates(nominal_model_of(dataset), dataset, Motion(np.eye(4), np.eye(4)), MEASURED)
    known = {candidate.key: candidate for candidate in candidates}
    hypothesis = Hypothesis(nominal_model_of(dataset))
    for key in keys:
        hypothesis = hypothesis.adding(known[key])
    return hypothesis


CUBIC = "cubic_spring {'node': 2, 'direction': 'x'}"
STOP = "gap_stop {'node': 3, 'direction': 'x', 'side': 1}"


@pytest.mark.parametrize(
    ("effect", "key", "theta", "size"),
    [
        (CubicSpring((2,), "x", 10.0), CUBIC, [10.0], 2.0),
        (GapStop((3,), "x", 0.3, 200.0, 1), STOP, [200.0, 0.3], 1.0),
    ],
)
def test_initial_states_under_a_law_are_as_probable_as_an_independent_optimiser_finds(
    effect: Effect, key: str, theta: list[float], size: float
) -> None:
    """Laws this strong bend the sum of squares so much that steps overshoot, and a search that begins far off fails."""
    dataset = chain(effect, size=size)
    hypothesis = with_causes(dataset, key)
    (batch,) = batches_of(dataset, "train")
    batch = batch.first(80)
    at = np.append(np.zeros(hypothesis.nuisances), theta)
    states, cost = initial_states(hypothesis, at, size**2 * np.eye(hypothesis.states), batch, NOISE_MODEL)
    system = system_of(hypothesis, at[None], NOISE_MODEL.outputs)
    for own, reached, data in zip(states, cost, batch.data, strict=True):

        def rest(state: FloatArray, data: FloatArray = data) -> FloatArray:
            y = respond(system, state[None, None], len(data))[0, 0]
            return np.append(((y - data) / NOISE).ravel(), state / size)

        # laws are tables as wide as the motions stepped together, a contact's edge by nodes that are not alike
        assert np.isclose(np.sum(rest(own) ** 2), reached, atol=2.0)
        best = 2 * least_squares(rest, own, x_scale=size).cost
        assert reached < best + 2.0  # likewise
        assert reached < 1.3 * data.size  # three standard deviations more than noise leaves: no local best
    beside = states + NOISE * np.random.default_rng(2).standard_normal(states.shape)
    again = initial_states(hypothesis, at, size**2 * np.eye(hypothesis.states), batch, NOISE_MODEL, near=beside)
    np.testing.assert_allclose(again[1], cost, atol=2.0)  # as above


def test_forecasts_of_a_linear_model_reach_the_floor_that_is_reported() -> None:
    dataset = chain()
    hypothesis = with_causes(dataset)
    model = ForecastModel(hypothesis, np.zeros(hypothesis.nuisances), np.eye(hypothesis.states))
    found = forecast(model, batches_of(dataset, "train"), VIEW)
    assert 0.8 < found.energy / found.floor_energy < 1.25  # 1440 values: a standard deviation of 0.04, states' besides


def test_floor_is_that_of_the_structure_whatever_the_model_has_more() -> None:
    """A support that gives way brings a coordinate in the middle of each state, of which the floor knows nothing."""
    dataset = recorded(masts())
    nominal, measured = nominal_model_of(dataset), tuple(range(len(dataset.sensors)))
    noise_model = NoiseModel(dataset.sensors, dataset.sampling_rate, np.full(len(measured), NOISE))
    motion = Motion.of_states(np.random.default_rng(0).standard_normal((50, 2 * nominal.size)), nominal.followed_shapes)
    soft = next(c for c in all_candidates(nominal, dataset, motion, measured) if c.brings)
    plain = Hypothesis(nominal)
    size = np.geomspace(1.0, 100.0, plain.states)  # of each entry another
    more = np.insert(size, [plain.size, 2 * plain.size], 1e3)
    theta = np.zeros(plain.nuisances)
    with_it = ForecastModel(plain.adding(soft), np.append(theta, soft.first_starts[0]), np.diag(more**2))
    (batch,) = batches_of(dataset, "train")
    floors = [
        forecast(model, (batch,), SensorRoles(dataset.sensors, measured, noise_model)).floor
        for model in (ForecastModel(plain, theta, np.diag(size**2)), with_it)
    ]
    np.testing.assert_allclose(floors[0], floors[1])


def test_model_less_a_cause_keeps_what_belongs_to_the_others() -> None:
    dataset = chain()
    forces = tuple(f"harmonic_force {{'node': {node}, 'direction': 'x'}}" for node in (1, 2))
    hypothesis = with_causes(dataset, forces[0], CUBIC, forces[1])
    theta = np.append(np.zeros(hypothesis.nuisances), [0.5, 100.0, 0.9])
    model = ForecastModel(hypothesis, theta, np.diag(np.arange(float(hypothesis.states))))
    fewer, left, spread = without(model, (0,))
    assert [candidate.key for candidate in fewer.candidates] == [CUBIC, forces[1]]
    np.testing.assert_array_equal(left[-2:], [100.0, 0.9])
    np.testing.assert_array_equal(spread, np.diag([*range(8), 10, 11]))
    none, left, spread = without(model, (0, 1, 2))
    assert not none.candidates
    assert (len(left), len(spread)) == (hypothesis.nuisances, 8)
    assert without(model, ())[0] is hypothesis


def test_recordings_before_and_after_tell_where_a_cause_acts() -> None:
    dataset = chain()
    hypothesis = with_causes(dataset, "stiffness_change {'element': 3}")
    (batch,) = batches_of(dataset, "train")
    batches = (replace(batch.take([0]), off=(0,)), batch.take([2]))
    item = fit(hypothesis, hypothesis.centre, batches, NOISE_MODEL)
    assert item is not None
    idle = idle_by_order(item, ["before", "r0", "between", "r2", "after"])
    assert idle == {
        "before": -FORECAST.order_cost,
        "r0": -FORECAST.order_cost,
        "r2": FORECAST.order_cost,
        "after": FORECAST.order_cost,
    }


@pytest.mark.parametrize("acts", [True, False])
def test_a_stop_that_is_not_hit_early_is_forecast_as_the_order_of_recordings_has_it(acts: bool) -> None:
    dataset = chain()
    hypothesis = with_causes(dataset, STOP)
    (batch,) = batches_of(dataset, "train")
    x3 = batch.data[..., 1]
    early, late = x3[:, : shown_of(batch.samples)].max(axis=1), x3.max(axis=1)
    number = int(np.argmax(late - early))
    gap = (early[number] + late[number]) / 2
    theta = np.append(np.zeros(hypothesis.nuisances), [200.0, gap])
    one = batch.take([number])
    model = ForecastModel(
        hypothesis,
        theta,
        np.eye(hypothesis.states),
        (0,),
        {one.names[0]: FORECAST.order_cost if acts else -FORECAST.order_cost},
    )
    y = predicted(model, one, VIEW)
    only = replace(model, switched=())
    other = ForecastModel(*without(only, (0,)))
    expected, unexpected = (predicted(m, one, VIEW) for m in ((only, other) if acts else (other, only)))
    np.testing.assert_array_equal(y, expected)
    assert np.abs(y - unexpected).max() > 10 * NOISE  # it is hit later


def test_what_is_left_elsewhere_is_that_of_the_best_initial_states_there() -> None:
    """Without its law a fit leaves what the linear model does, whose initial states are solved for."""
    dataset = chain(CubicSpring((2,), "x", 1.0))
    hypothesis = with_causes(dataset, CUBIC)
    plain = Hypothesis(hypothesis.nominal)
    batches = batches_of(dataset, "train")
    linear = fit(plain, plain.centre, batches, NOISE_MODEL)
    assert linear is not None
    item = fit(hypothesis, np.append(linear.theta, 1.0), batches, NOISE_MODEL, linear.states)
    assert item is not None
    without_it, expected = residuals_at(item, np.append(linear.theta, 0.0), NOISE_MODEL), linear.residuals
    assert without_it[0] is not None
    np.testing.assert_allclose(without_it[0], expected[0], atol=1e-3)  # of the noise: steps of finite differences
    assert residuals_at(item, np.append(linear.theta, -100.0), NOISE_MODEL) == (None,)  # it grows beyond all bounds


def test_a_motion_beyond_all_bounds_is_far_from_what_was_recorded_in_whatever_unit() -> None:
    """A million was far from metres, and a hundredth of what nanometres show."""
    dataset = chain()
    softening = with_causes(dataset, CUBIC)
    theta = np.append(np.zeros(softening.nuisances), -1e6)
    (batch,) = batches_of(dataset, "train")
    small = SensorRoles(SENSORS, MEASURED, replace(NOISE_MODEL, sigma=NOISE_MODEL.sigma * 1e9))
    large = replace(batch, data=batch.data * 1e9)
    assert (
        forecast(ForecastModel(softening, theta, 1e18 * np.eye(softening.states)), (large,), small).nrmse > 1e3
    ).all()


@pytest.mark.parametrize("count", [1, 3, 12])
def test_initial_states_are_known_beforehand_at_any_phase(count: int) -> None:
    """Of motions that begin at any phase, modes of known size: what few of them tell holds for others."""
    rng = np.random.default_rng(count)
    dataset = chain()
    hypothesis = with_causes(dataset)
    item = fit(hypothesis, np.zeros(hypothesis.nuisances), batches_of(dataset, "train"), NOISE_MODEL)
    assert item is not None
    A = system_of(hypothesis, item.theta[None], NOISE_MODEL.outputs).A[0]
    roots, vectors = np.linalg.eig(A)
    size = np.array([1.0, 0.3, 0.1, 0.03])  # of the modes, the slowest first
    order = np.argsort(np.abs(roots[roots.imag > 0]))
    shapes = vectors[:, roots.imag > 0][:, order]

    def drawn(number: int) -> FloatArray:
        phases = np.exp(2j * np.pi * rng.uniform(size=(number, 4)))
        return np.asarray(2 * np.real((size * phases) @ shapes.T))

    spread = model_of(replace(item, states=(drawn(count),)), NOISE_MODEL).spread
    square = np.mean(np.einsum("rs,st,rt->r", *(lambda x: (x, precision_of(spread), x))(drawn(2000))))
    wider = (student(2 * count).ppf(0.99) / norm.ppf(0.99)) ** 2
    assert square == pytest.approx(8 / wider, rel=0.05)  # eight entries, of variance one each if they were normal


def test_errors_of_a_perfect_model_scatter_as_estimated() -> None:
    """Noise and initial states that are drawn as the model knows them, 300 recordings one by one."""
    rng = np.random.default_rng(5)
    hypothesis = with_causes(chain())
    theta = np.zeros(hypothesis.nuisances)
    model = ForecastModel(hypothesis, theta, 0.01 * np.eye(hypothesis.states))
    states = 0.1 * rng.standard_normal((300, hypothesis.states))
    clean = respond(system_of(hypothesis, theta[None], NOISE_MODEL.outputs), states[None], 100)[0]
    data = clean + NOISE * rng.standard_normal(clean.shape)
    found = [forecast(model, (Batch(one[None], ("r",)),), VIEW) for one in data]
    off = np.array([(item.energy - item.floor_energy) / item.chance for item in found])
    assert abs(off.mean()) < 3 / np.sqrt(300)
    assert off.std() == pytest.approx(1.0, abs=0.15)  # three of its own standard deviations, of squares of few states
    assert np.mean([item.is_perfect for item in found]) > 0.97  # beyond three, sums of few squares are 0.3 to 1.5 %
    softer = replace(model, theta=np.append(-1.5, theta[1:]))  # one spring, to a quarter
    assert not forecast(softer, (Batch(data, ("r",) * 300),), VIEW).is_perfect
