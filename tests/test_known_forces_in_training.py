"""Known loads and base motion in the hybrid model's training: against motion by scipy, and what must not change."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import torch

from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.errors import InputError
from fe_models.mechanisms import factorise
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Load, Recording, Sensor
from hybrid.config import Config, ModelConfig, TrainingConfig, experts_preset, places_preset
from hybrid.estimation.forecast import forecast_windows
from hybrid.estimation.linear_calibration import Observer, fit_linear_rest
from hybrid.estimation.linear_recursion import BLOCK, linear_recursion
from hybrid.estimation.windows import cut_all, cut_driving, driving_of
from hybrid.known_loads.modal_input import modal_input
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.scaling import StateScale
from hybrid.training.expert_preparation import prepare_experts
from hybrid.training.forecast_comparison import compare
from hybrid.training.preparation import prepare
from hybrid.training.scoring import nrmse
from hybrid.training.trainers import trainer_for
from tests.driven_problems import loaded_dataset, loaded_recording, shaken_recording, smooth_force
from tests.hybrid_problems import (
    MEASURED,
    OFF_FREQUENCY,
    SENSORS,
    STEP,
    TINY,
    chain_dataset,
    chain_modes,
    double_precision,
    learned,
    off_chain,
    same,
)
from tests.shaken_mast import MAST

PLACES = Config(
    replace(places_preset().model, substeps=4),
    TrainingConfig(epochs=25, batch=100, window=160, first_horizon=80),
)


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


def model_as_drawn(dataset: Dataset) -> NeuralModalODE:
    """The chain's modes without anything learned, so that its linear motion is exact."""
    config = ModelConfig(net_hidden=4)
    channels = torch.ones(len(dataset.sensors))
    return NeuralModalODE(config, chain_modes(), (), dataset.sensors, channels, StateScale.unit(4), STEP)


def test_from_rest_under_two_loads_the_model_moves_as_the_masses_do() -> None:
    """In displacements, velocities and accelerations; 1e-6: what scipy leaves."""
    recording = loaded_recording("r", chain_modes(), 3)
    dataset = Dataset(four_dof(), 1 / STEP, SENSORS, (recording,))
    driving = driving_of(modal_input(dataset, chain_modes(), [recording]), recording)
    with torch.no_grad():
        found = model_as_drawn(dataset).forecast(torch.zeros(1, 8), 160, driving).channels[0].numpy()
    np.testing.assert_allclose(found, recording.data[0], rtol=0, atol=1e-6 * np.abs(recording.data).max())


def test_on_a_moving_base_sensors_show_the_absolute_motion_or_that_relative_to_it() -> None:
    sensors = tuple(
        Sensor(f"{quantity}{reference}", node, "x", quantity, "m", reference=reference)  # type: ignore[arg-type]
        for node, quantity in ((4, "displacement"), (2, "velocity"), (1, "acceleration"))
        for reference in ("absolute", "base")
    )
    recording = shaken_recording(chain_modes(), sensors)
    dataset = Dataset(four_dof(), 1 / STEP, sensors, (recording,))
    driving = driving_of(modal_input(dataset, chain_modes(), [recording]), recording)
    with torch.no_grad():
        found = model_as_drawn(dataset).forecast(torch.zeros(1, 8), 160, driving).channels[0].numpy()
    np.testing.assert_allclose(found, recording.data[0], rtol=0, atol=1e-6 * np.abs(recording.data).max())


def test_slow_loads_bend_modes_that_are_left_out_as_statics_say() -> None:
    """A force at a fiftieth of the first frequency that is left out; 1e-4: the square of that, and the first mode."""
    modal = natural_modes(linearise(MAST), 1)
    sensor = Sensor("x3", 3, "x", "displacement", "m")
    slow = np.sin(2 * np.pi * 0.02 * np.arange(200) / 10.0)
    recording = Recording("r", np.zeros((1, 200, 1)), loads=(Load(4, "x", slow),))
    forces = modal_input(Dataset(MAST, 10.0, (sensor,), (recording,)), modal, [recording])
    assert forces is not None
    linear = linearise(MAST)
    pull = modal.dofs.pull([(4, "x", 1.0)])[modal.dofs.free]
    exact = modal.dofs.expand(factorise(linear.stiffness).solve(pull))[modal.dofs.row(3, "x")]
    by_mode = modal.shapes[modal.dofs.row(3, "x"), 0] * forces.participation[0, 0] / modal.omega[0] ** 2
    found = by_mode * slow + forces.shown_at_once(recording, forces.courses(recording))[:, 0]
    assert abs(by_mode / exact - 1) > 0.01
    np.testing.assert_allclose(found[20:-20], exact * slow[20:-20], rtol=0, atol=1e-4 * exact)


def test_modes_within_the_band_that_are_left_out_are_not_taken_for_static() -> None:
    """The mast's second mode, at 7.8 Hz, would answer to a force of 40 Hz with a small part of what statics say."""
    recording = Recording("r", np.zeros((1, 200, 1)), loads=(Load(4, "x", np.ones(200)),))
    dataset = Dataset(MAST, 100.0, (Sensor("x3", 3, "x", "displacement", "m"),), (recording,))
    forces = modal_input(dataset, natural_modes(linearise(MAST), 1), [recording])
    assert forces is not None
    assert len(forces.shown) == 0


@pytest.mark.parametrize("count", [1, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 5])
def test_the_recursion_in_blocks_is_that_of_a_loop(count: int) -> None:
    """1e-13: rounding of fifty products."""
    generator = torch.Generator().manual_seed(1)
    start, pushes = torch.randn(3, 4, generator=generator), torch.randn(3, count, 4, generator=generator)
    transition = 0.4 * torch.randn(4, 4, generator=generator)
    expected = [start]
    for k in range(count):
        expected.append(expected[-1] @ transition + pushes[:, k])
    found = linear_recursion(start, pushes, transition)
    np.testing.assert_allclose(found, torch.stack(expected, dim=1), rtol=0, atol=1e-13)


@pytest.mark.slow
def test_frequencies_and_damping_are_found_from_recordings_that_begin_at_rest() -> None:
    """As from free decays: to 1e-3 without noise."""
    dataset = loaded_dataset(off_chain(), 2)
    recordings, sensors = dataset.select("train"), [SENSORS[i] for i in MEASURED]
    windows = torch.tensor(cut_all(recordings, 160, 20)[:, :, MEASURED])
    driving = cut_driving(modal_input(dataset, chain_modes(), recordings), recordings, 160, 20)
    assert driving is not None
    observer = Observer(chain_modes(), sensors, STEP)
    fit = fit_linear_rest(observer, windows, driving=driving.of_sensors(MEASURED))
    stiffness, damping = (part.numpy() for part in observer.rates(torch.tensor(fit.rest)))
    omega = observer.omega.numpy()
    A = np.block([[np.zeros((4, 4)), np.diag(omega)], [stiffness, damping]])
    roots = np.linalg.eigvals(A)
    found = np.sort(np.abs(roots[roots.imag > 0]))
    np.testing.assert_allclose(found, np.sort(omega * OFF_FREQUENCY), rtol=1e-3)


def test_loads_of_zero_change_nothing() -> None:
    """But for scales, which then follow whole motions. 1e-5: where two searches stop that round differently."""
    free = chain_dataset(realisations=4)
    nothing = (Load(1, "x", np.zeros(100)),)
    loaded = replace(free, recordings=tuple(replace(each, loads=nothing) for each in free.recordings))
    first, second = (prepare(each, TINY) for each in (free, loaded))
    assert second.driving is not None
    assert first.unexplained == pytest.approx(second.unexplained, rel=1e-5)
    linear = []
    for dynamics in (first.model.dynamics, second.model.dynamics):
        size = torch.cat([dynamics.a, dynamics.b])
        linear.append((dynamics.linear_part() * size[:, None] / size).detach().numpy())
    np.testing.assert_allclose(linear[0], linear[1], rtol=0, atol=1e-5)


def test_training_by_gradients_under_loads_learns_what_the_drawing_lacks() -> None:
    """Frequencies 10 % off leave the FE model with errors as large as the motion."""
    dataset = loaded_dataset(off_chain(), 3, noise=0.01)
    prepared = prepare(dataset, TINY)
    trainer = trainer_for(prepared.model, prepared.windows, TINY.training, driving=prepared.driving)
    for _ in trainer.epochs():
        pass
    found = compare(prepared.model, dataset, 80, 20)
    assert found is not None
    hybrid, fe = (float(nrmse(each.channels, found.windows).mean()) for each in (found.hybrid.forecast, found.fe))
    assert hybrid < 0.25 * fe


def test_without_its_loads_a_loaded_window_is_forecast_wrongly() -> None:
    """So that a forecast which loses them on the way is noticed."""
    dataset = loaded_dataset(chain_modes(), 2)
    recordings = dataset.select("test")
    windows = cut_all(recordings, 80, 20)
    driving = cut_driving(modal_input(dataset, chain_modes(), recordings), recordings, 80, 20)
    prepared = prepare(dataset, TINY)
    known, unknown = (forecast_windows(prepared.model, windows, driving=each).channels for each in (driving, None))
    assert nrmse(known, windows).mean() < 0.1 * nrmse(unknown, windows).mean()


@pytest.mark.slow
def test_nets_at_places_learn_a_cubic_spring_under_loads() -> None:
    """Nothing but the spring, 0.5 N/m^3, is wrong: most of what the linear model leaves is learned."""
    dataset = loaded_dataset(chain_modes(0.02), 6, noise=0.005, cubic=0.5)
    dataset = replace(dataset, assumptions=replace(dataset.assumptions, modal_model=chain_modes(0.02)))
    prepared = prepare(dataset, PLACES)
    trainer = trainer_for(prepared.model, prepared.windows, PLACES.training, driving=prepared.driving)
    before = compare(prepared.model, dataset, 160, 1)
    for _ in trainer.epochs():
        pass
    after = compare(prepared.model, dataset, 160, 1)
    assert before is not None
    assert after is not None
    errors = [float(nrmse(each.hybrid.forecast.channels, each.windows).mean()) for each in (before, after)]
    assert errors[1] < 0.3 * errors[0], errors


def test_the_same_seed_gives_the_same_bits_and_another_load_another_model() -> None:
    dataset = loaded_dataset(off_chain(), 2)
    louder = tuple(
        replace(each, loads=tuple(replace(load, values=1.1 * load.values) for load in each.loads))
        for each in dataset.recordings
    )
    weights = []
    for each in (dataset, dataset, replace(dataset, recordings=louder)):
        prepared = prepare(each, TINY)
        trainer = trainer_for(prepared.model, prepared.windows, TINY.training, driving=prepared.driving)
        next(trainer.epochs())
        weights.append(learned(prepared.model))
    assert same(weights[0], weights[1])
    assert not same(weights[0], weights[2])


def test_experts_take_no_known_forces() -> None:
    with pytest.raises(InputError, match="experts are weighed by how free motions begin"):
        prepare_experts(loaded_dataset(chain_modes(), 1), experts_preset())


def test_channels_without_units_and_ambient_training_recordings_are_refused_with_the_remedy() -> None:
    dataset = loaded_dataset(chain_modes(), 1)
    bare = tuple(replace(sensor, unit="1") for sensor in SENSORS[:2])
    with pytest.raises(InputError) as caught:
        prepare(replace(dataset, sensors=(*bare, *SENSORS[2:])), TINY)
    assert [fault.split(":")[0] for fault in caught.value.faults] == [
        f'sensor {name!r} has the unit "1"' for name in ("x4", "a1")
    ]
    wind = replace(chain_dataset().recordings[0], name="wind", excitation="ambient")
    with pytest.raises(InputError, match=r"'wind' is ambient vibration.*role = .test"):
        prepare(replace(dataset, recordings=(*dataset.recordings, wind)), TINY)


def test_of_a_knock_that_samples_do_not_tell_what_comes_after_is_learned_as_free_motion() -> None:
    dataset = chain_dataset(realisations=1)
    knock = np.zeros(100)
    knock[3:5] = 40.0
    knocked = replace(dataset.recordings[0], loads=(Load(1, "x", knock),))
    prepared = prepare(replace(dataset, recordings=(knocked, *dataset.recordings[1:])), TINY)
    assert prepared.driving is None
    assert np.array_equal(prepared.windows[0], knocked.data[0, 6:86])


def test_a_load_and_its_derivatives_are_those_of_whole_recordings_in_every_window() -> None:
    """A window's own spline would end elsewhere."""
    dataset = loaded_dataset(chain_modes(), 1)
    recordings = dataset.select("train")
    driving = cut_driving(modal_input(dataset, chain_modes(), recordings), recordings, 60, 20)
    whole = driving_of(modal_input(dataset, chain_modes(), recordings), recordings[0])
    assert driving is not None
    assert whole is not None
    assert torch.equal(driving.courses[2], whole.courses[0, 40:100])
    np.testing.assert_allclose(whole.courses[0, :, 0, 0], smooth_force(160, 0, 0.5), atol=1e-12)
