"""The chain of the paper, and its data to the authors' own numbers."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.assembly import linearise
from fe_models.built_in.four_dof import PAPER_OMEGA, four_dof
from fe_models.causes import CubicSpring
from fe_models.four_dof_data import paper_dataset, paper_sensors
from fe_models.modes import natural_modes
from fe_models.simulation import simulate_free


def test_matrices_are_the_paper_s() -> None:
    model = linearise(four_dof())
    np.testing.assert_array_equal(model.mass.toarray(), np.diag([1.0, 2.0, 3.0, 4.0]))
    np.testing.assert_array_equal(model.damping.toarray(), 0.1 * np.eye(4))
    stiffness = [[3, -2, 0, 0], [-2, 5, -3, 0], [0, -3, 7, -4], [0, 0, -4, 4]]
    np.testing.assert_array_equal(model.stiffness.toarray(), stiffness)


def test_modes_are_the_paper_s() -> None:
    modes = natural_modes(linearise(four_dof()), 4)
    np.testing.assert_allclose(modes.omega, PAPER_OMEGA, atol=5e-5)  # printed to four digits
    # printed in tenths of 1 %
    np.testing.assert_allclose(modes.damping_ratio, [0.070, 0.025, 0.016, 0.015], atol=5.1e-4)


def test_cubic_spring_joins_the_first_mass_to_the_ground() -> None:
    assert four_dof().effects == ()
    assert four_dof(0.5).effects == (CubicSpring((1,), "x", 0.5),)
    # At rest it has no stiffness.
    np.testing.assert_array_equal(
        linearise(four_dof(0.5)).stiffness.toarray(), linearise(four_dof()).stiffness.toarray()
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("cubic", "first", "last", "spread"),
    [
        (0.0, [1.801831, 0.565809, -1.497898, 1.649158], [-0.279726, -0.163754, -0.553911, 0.199011], 1.150599),
        (1.0, [1.800702, 0.565515, -1.498944, 1.647488], [-0.454421, 0.444187, 0.299539, -0.127893], 1.169865),
    ],
)
def test_data_are_the_authors_own(cubic: float, first: list[float], last: list[float], spread: float) -> None:
    dataset = paper_dataset(cubic)
    data = np.concatenate([recording.data for recording in dataset.recordings])
    assert data.shape == (1000, 501, 12)
    names = [sensor.name for sensor in dataset.sensors]
    # The authors' solver, with its default tolerances, is off by about 1e-6.
    np.testing.assert_allclose(data[0, 0, :4], first, atol=2e-6)
    columns = [names.index(name) for name in ("x4", "a1", "a3", "a4")]
    np.testing.assert_allclose(data[999, 500, columns], last, atol=2e-6)
    assert data.std() == pytest.approx(spread, abs=2e-6)


def test_data_hold_three_percent_of_noise_per_realisation() -> None:
    dataset = paper_dataset(1.0, rng=np.random.RandomState(7), realisations=20)
    rng = np.random.RandomState(7)
    start = rng.randn(8, 20)
    truth = simulate_free(four_dof(1.0), start[:4].T, start[4:].T)
    data = np.concatenate([recording.data for recording in dataset.recordings])
    states = np.concatenate([truth.displacement, truth.velocity], axis=2)
    noise = (data[..., :8] - states).std(axis=(1, 2)) / states.std(axis=(1, 2))  # (realisation,)
    np.testing.assert_allclose(noise, 0.03, rtol=0.06)  # four standard errors of 4008 numbers: 4.5 %
    rates = np.concatenate([truth.velocity, truth.acceleration], axis=2)
    rate_noise = (data[..., 8:] - truth.acceleration).std(axis=(1, 2)) / rates.std(axis=(1, 2))
    np.testing.assert_allclose(rate_noise, 0.03, rtol=0.09)  # half as many numbers


def test_dataset_measures_four_channels_of_the_linear_chain() -> None:
    dataset = paper_dataset(0.5, realisations=10)
    assert [sensor.name for sensor in dataset.sensors if sensor.role == "measured"] == ["x4", "a1", "a3", "a4"]
    assert [sensor.name for sensor in paper_sensors()] == [
        f"{letter}{node}" for letter in "xva" for node in range(1, 5)
    ]
    assert [(recording.name, len(recording.data)) for recording in dataset.recordings] == [("train", 8), ("test", 2)]
    assert dataset.model == four_dof()
    assert dataset.sampling_rate == 10.0


def test_dataset_takes_the_user_s_modal_model() -> None:
    modes = natural_modes(linearise(four_dof()), 4)
    wrong = replace(modes, omega=1.03 * modes.omega)
    assert paper_dataset(modal_model=wrong, realisations=2).assumptions.modal_model is wrong
