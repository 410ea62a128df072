"""What geometry adds to a frame's linear motion: closed forms, and a bridge that is geometrically exact."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.blind import BlindConfig, blind_case
from fe_models.four_dof import four_dof
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import Beam, Direction, Structure, Support
from hybrid.diagnosis.contest.growing import fit_growing, ground_of
from hybrid.diagnosis.contest.setting import Setting, setting_of
from hybrid.diagnosis.contest.straightening import straighten
from hybrid.diagnosis.fitting.fitting import fit
from hybrid.diagnosis.fitting.forecasting import forecast, model_of
from hybrid.diagnosis.fitting.geometry_response import straightened
from hybrid.diagnosis.nominal.geometry_forces import geometry_of
from hybrid.diagnosis.nominal.plant import Plant, plant_of
from hybrid.diagnosis.recorded.records import batches_of, columns_of
from tests.problems import TIMBER

LENGTH, PIECES = 2.0, 16
SENSOR = (Sensor("w", 1 + PIECES // 2, "y", "displacement", "m"),)


def hinged(*held_at_the_end: Direction) -> Plant:
    """A beam on two hinges, the second of which may slide, and its first mode alone."""
    nodes = tuple((LENGTH * i / PIECES, 0.0) for i in range(PIECES + 1))
    structure = Structure(
        "hinged",
        nodes,
        tuple(Beam((i, i + 1), TIMBER) for i in range(1, PIECES + 1)),
        supports=(Support(1, ("x", "y")), Support(PIECES + 1, held_at_the_end)),
    )
    recording = Recording("r", np.zeros((1, 10, 1)))
    plant = plant_of(Dataset(structure, 400.0, SENSOR, (recording,), 30.0))
    assert plant.kept == 1  # 11 Hz; the second is at 45 Hz
    return plant


def force_at(plant: Plant, deflection: float) -> float:
    """The force (N) of half a sine wave's work at its middle, on top of the elastic one."""
    shape = plant.modes[1][:, 0]
    middle = shape[plant.dofs.row(1 + PIECES // 2, "y")]
    geometry = geometry_of(plant, np.outer([-deflection, deflection], shape / middle), np.random.default_rng(1))
    assert geometry is not None
    return float(geometry.at(np.array([deflection / middle]))[0] / middle)


def test_a_hinged_beam_that_cannot_slide_stiffens_as_its_middle_line_stretches() -> None:
    """Potential energy E A L e^2 / 2 of the mean strain e = (pi w / (2 L))^2: force E A pi^4 w^3 / (8 L^3)."""
    deflection = 0.002
    expected = -TIMBER.youngs_modulus * TIMBER.area * np.pi**4 * deflection**3 / (8 * LENGTH**3)
    # Straight elements stretch by (pi / 16)^2 / 6 = 0.6 % less than the sine wave does.
    assert force_at(hinged("x", "y"), deflection) == pytest.approx(expected, rel=1e-2)


def test_one_that_can_slide_hardly_does() -> None:
    held, sliding = (abs(force_at(plant, 0.002)) for plant in (hinged("x", "y"), hinged("y")))
    assert sliding < 1e-3 * held  # the ends draw together; what is left is (pi w / L)^2 of the elastic force


def test_a_chain_has_none() -> None:
    plant = plant_of(Dataset(four_dof(), 10.0, (), ()))
    assert geometry_of(plant, np.ones((3, 4)), np.random.default_rng(1)) is None


@pytest.fixture(scope="module")
def bridge_setting() -> Setting:
    config = BlindConfig(structure="bridge", off=True, noise=0.01, train=2, test=1, duration=7.99)
    return setting_of(blind_case(61000, config).dataset)


def test_a_geometrically_exact_bridge_leaves_noise_alone_and_is_forecast(bridge_setting: Setting) -> None:
    setting, gauge = bridge_setting, bridge_setting.gauge
    hypothesis = replace(setting.nominal, plant=replace(setting.plant, geometry=setting.geometry))
    bent = fit_growing(hypothesis, hypothesis.centre, setting.lengths, gauge, setting.short)
    assert bent is not None
    straight = straightened(bent, gauge)
    assert straight is not None
    item = fit(bent.hypothesis, bent.theta, straight, gauge, bent.states)
    assert item is not None
    # Noise as the recordings tell it is right to some 5 %.
    assert item.chi2 < 1.15 * item.values < 1.3 * item.values < bent.chi2
    linear = replace(item.hypothesis, plant=replace(item.hypothesis.plant, geometry=None))
    found, without = (
        forecast(model_of(each, gauge), straight, gauge.sensors, gauge.positions, gauge)
        for each in (item, replace(item, hypothesis=linear))
    )
    assert found.nrmse.mean() < 1.1 * found.floor.mean() < 1.5 * found.floor.mean() < without.nrmse.mean()


def test_what_was_recorded_is_scored_not_what_was_fitted(bridge_setting: Setting) -> None:
    """A fit's own batches, straightened or not, have the same forecasts."""
    setting = bridge_setting
    item = replace(setting.short, batches=setting.lengths.whole)
    (batch,) = columns_of(batches_of(setting.dataset, "train"), setting.measured)
    model = model_of(item, setting.gauge)
    found = [
        forecast(model, (each,), setting.gauge.sensors, setting.gauge.positions, setting.gauge).energy
        for each in (batch, batch.less(0.1 * batch.data))
    ]
    assert found[0] == found[1]


def test_geometry_is_taken_away_where_the_recordings_show_it_and_nowhere_else() -> None:
    """The same two cases: a bridge that is geometrically exact, and one that its user made linear."""
    for seed, rich in ((61000, True), (61000, False)):
        config = BlindConfig(structure="bridge", noise=0.01, train=2, test=1, duration=7.99, rich=rich)
        setting = setting_of(blind_case(seed, config).dataset)
        begun = ground_of(setting.nominal, setting.nominal.centre, setting.lengths, setting.gauge, setting.short)
        assert begun is not None
        ground, lengths = straighten(begun, begun.whole, setting.lengths, setting.gauge, setting.geometry)
        assert (ground.hypothesis.plant.geometry is setting.geometry) == rich
        assert (lengths is setting.lengths) != rich
        # Noise as the recordings tell it is right to some 5 %.
        assert ground.whole.chi2 < 1.15 * ground.whole.values
