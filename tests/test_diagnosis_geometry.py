"""What geometry adds to a frame's linear motion: closed forms, and a bridge that is geometrically exact."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.built_in.four_dof import four_dof
from fe_models.causes.places import Motion
from fe_models.recordings import Dataset, Quantity, Recording, Sensor
from fe_models.structure import Beam, Direction, Structure, Support
from hybrid.diagnosis.contest.evidence import Evidence
from hybrid.diagnosis.contest.growing import fit_growing, reference_fits_of
from hybrid.diagnosis.contest.posterior import posterior_of
from hybrid.diagnosis.contest.setting import Setting, setting_of
from hybrid.diagnosis.contest.straightening import straighten
from hybrid.diagnosis.fitting.driven import states_along
from hybrid.diagnosis.fitting.forecast_score import begun_from, forecast, is_bent, model_of, predicted
from hybrid.diagnosis.fitting.geometry_response import added_motion, straightened
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.nominal.geometry_forces import geometries_of
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.recorded.batches import Batch, batches_of, columns_of
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import linear_channels
from tests.problems import CANTILEVER_ROOTS, TIMBER, cantilever

LENGTH, PIECES = 2.0, 16
DEFLECTION, SWAY = 0.002, 0.001  # m; of a mode of unit modal mass


def rng() -> np.random.Generator:
    return np.random.default_rng(1)


def model_below(structure: Structure, lowpass: float, kept: int) -> NominalModel:
    """Return the nominal model of a structure in whose recordings ``kept`` modes show."""
    sensors = (Sensor("w", 2, "y", "displacement", "m"),)
    nominal = nominal_model_of(Dataset(structure, 400.0, sensors, (Recording("r", np.zeros((1, 10, 1))),), lowpass))
    assert nominal.kept == kept
    return nominal


def hinged(pieces: int, *held_at_the_end: Direction) -> Structure:
    """A beam on two hinges, the second of which may slide; natural frequencies 11, 45 and 101 Hz."""
    return Structure(
        "hinged",
        tuple((LENGTH * i / pieces, 0.0) for i in range(pieces + 1)),
        tuple(Beam((i, i + 1), TIMBER) for i in range(1, pieces + 1)),
        supports=(Support(1, ("x", "y")), Support(pieces + 1, held_at_the_end)),
    )


def forces_at(nominal: NominalModel) -> list[float]:
    """The force (N) of half a sine wave's work at its middle, on top of the elastic one, as each geometry tells it."""
    shape = nominal.modes[1][:, 0]
    middle = shape[nominal.dofs.row(1 + len(nominal.structure.elements) // 2, "y")]
    motion = np.outer([-DEFLECTION, DEFLECTION], shape / middle)
    found = geometries_of(nominal, motion, rng())
    return [float(geometry.at(np.array([DEFLECTION / middle]))[0] / middle) for geometry in found]


@pytest.mark.parametrize("pieces", [4, PIECES])
def test_a_hinged_beam_that_cannot_slide_stiffens_as_its_middle_line_stretches(pieces: int) -> None:
    """Potential energy E A L e^2 / 2 of the mean strain e = (pi w / (2 L))^2: force E A pi^4 w^3 / (8 L^3).

    On any mesh; that of long elements is computed beside it.
    """
    expected = -TIMBER.youngs_modulus * TIMBER.area * np.pi**4 * DEFLECTION**3 / (8 * LENGTH**3)
    beam, *drawn = forces_at(model_below(hinged(pieces, "x", "y"), 30.0, kept=1))
    # Straight elements stretch by (pi / 16)^2 / 6 = 0.6 % less than the sine wave does, and four of them by a tenth.
    assert beam == pytest.approx(expected, rel=1e-2)
    assert len(drawn) == (pieces == 4)
    assert all(force / expected == pytest.approx(0.9, abs=0.03) for force in drawn)


def test_one_that_can_slide_hardly_does() -> None:
    beams = hinged(PIECES, "x", "y"), hinged(PIECES, "y")
    held, sliding = (abs(forces_at(model_below(beam, 30.0, kept=1))[0]) for beam in beams)
    assert sliding < 1e-3 * held  # the ends draw together; what is left is (pi w / L)^2 of the elastic force


def test_a_mode_that_hardly_moves_meets_itself_in_products_of_two_alone() -> None:
    nominal = model_below(hinged(PIECES, "x", "y"), 50.0, kept=2)
    (geometry,) = geometries_of(nominal, np.diag([1e-3, 1e-6]) @ nominal.modes[1].T, rng())
    assert geometry.powers.tolist() == [[2, 0], [1, 1], [0, 2], [3, 0], [2, 1]]


@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration"])
def test_a_column_that_sways_is_shortened_as_a_sensor_shows(quantity: Quantity) -> None:
    """Its end draws back by x = 1/2 int w'^2 ds: with w ~ cos(omega t), x ~ (1 + cos(2 omega t)) / 2."""
    column = cantilever(LENGTH, 8)
    nominal = model_below(column, 20.0, kept=1)  # 4.0 Hz; the second is at 25 Hz
    (omega,), shape = nominal.modes[0], nominal.modes[1][:, 0]
    (geometry,) = geometries_of(nominal, SWAY * np.array([shape, -shape]), rng())
    hypothesis, sensors = Hypothesis(replace(nominal, geometry=geometry)), (Sensor("x", 2, "x", quantity, "-"),)
    batch = Batch(np.zeros((1, 400, 1)), ("r",))
    shown = added_motion(
        hypothesis, hypothesis.centre, np.array([[SWAY, 0.0]]), batch, SensorOutputs.measured(sensors, 400.0)
    )[0, :, 0]
    root = CANTILEVER_ROOTS[0] / LENGTH
    bend = 0.5 * SWAY * shape[nominal.dofs.row(2, "y")]  # half of what the end does, as its shape is 2 there
    sigma = (np.cosh(root * LENGTH) + np.cos(root * LENGTH)) / (np.sinh(root * LENGTH) + np.sin(root * LENGTH))
    slope, _ = quad(
        lambda s: (root * (np.sinh(root * s) + np.sin(root * s) - sigma * (np.cosh(root * s) - np.cos(root * s)))) ** 2,
        0,
        LENGTH,
    )
    x, twice = 0.25 * bend**2 * slope, 2 * omega * np.arange(400) / 400.0
    expected = {
        "displacement": -x * (1 + np.cos(twice)),
        "velocity": x * 2 * omega * np.sin(twice),
        "acceleration": x * (2 * omega) ** 2 * np.cos(twice),
    }[quantity]
    inside = slice(20, -20)  # where a spline ends, its second derivative is rough
    # The mesh's shortening is within 1 %, and the motion within 1 % of the one without what geometry adds.
    np.testing.assert_allclose(shown[inside], expected[inside], atol=0.02 * np.abs(expected).max())


@pytest.mark.parametrize("mesh", [0, 1])
def test_the_mesh_that_recordings_come_from_is_estimated_from_them(mesh: int) -> None:
    """That of one element shortens the column by a fifth less."""
    column, rate = cantilever(LENGTH, 1), 400.0
    sensors = Sensor("x", 2, "x", "displacement", "m"), Sensor("y", 2, "y", "displacement", "m")
    outputs = SensorOutputs.measured(sensors, rate)
    nominal = model_below(column, 20.0, kept=1)
    (omega,), shapes = nominal.modes
    geometries = geometries_of(nominal, SWAY * np.array([[1.0], [-1.0]]) @ shapes.T, rng())
    hypothesis = Hypothesis(replace(nominal, geometry=geometries[mesh]))
    batch, start = Batch(np.zeros((2, 400, 2)), ("a", "b")), SWAY * np.array([[1.0, 0.0], [0.0, omega]])
    system = system_of(hypothesis, hypothesis.centre[None], outputs)
    clean = linear_channels(system, start[None], 400)[0]
    clean = clean + added_motion(hypothesis, hypothesis.centre, start, batch, outputs)
    data = clean + 0.03 * clean.std(axis=(0, 1)) * rng().standard_normal(clean.shape)
    recordings = tuple(Recording(name, own[None]) for name, own in zip("ab", data, strict=True))
    setting = setting_of(Dataset(column, rate, sensors, recordings, 20.0))
    begun = reference_fits_of(
        setting.nominal_hypothesis,
        setting.nominal_hypothesis.centre,
        setting.lengths,
        setting.noise_model,
        setting.short,
    )
    assert begun is not None
    ground, _ = straighten(begun, begun.whole, setting.lengths, setting.noise_model, setting.geometries)
    assert ground.hypothesis.nominal.geometry is setting.geometries[mesh]


def test_a_chain_has_none() -> None:
    nominal = nominal_model_of(Dataset(four_dof(), 10.0, (), ()))
    assert not geometries_of(nominal, np.ones((3, 4)), rng())


@pytest.fixture(scope="module")
def bridge_setting() -> Setting:
    config = BlindConfig(structure="bridge", tier="off", noise=0.01, train=2, test=1, duration=7.99)
    return setting_of(blind_case(61000, config).dataset)


@pytest.fixture(scope="module")
def bent_fit(bridge_setting: Setting) -> Fit:
    """The fit of a geometrically exact bridge less what geometry adds to its motion."""
    setting, noise_model = bridge_setting, bridge_setting.noise_model
    hypothesis = replace(setting.nominal_hypothesis, nominal=replace(setting.nominal, geometry=setting.geometries[0]))
    bent = fit_growing(hypothesis, hypothesis.centre, setting.lengths, noise_model, setting.short)
    assert bent is not None
    straight = straightened(bent, noise_model)
    assert straight is not None
    item = fit(bent.hypothesis, bent.theta, straight, noise_model, bent.states)
    assert item is not None
    # Noise as the recordings tell it is right to some 5 %.
    assert item.chi2 < 1.15 * item.values < 1.3 * item.values < bent.chi2
    return item


def made_linear(item: Fit) -> Fit:
    return replace(item, hypothesis=replace(item.hypothesis, nominal=replace(item.hypothesis.nominal, geometry=None)))


@pytest.mark.slow
def test_a_geometrically_exact_bridge_leaves_noise_alone_and_is_forecast(
    bridge_setting: Setting, bent_fit: Fit
) -> None:
    noise_model, both = bridge_setting.noise_model, (bent_fit, made_linear(bent_fit))
    found, without = (forecast(model_of(each, noise_model), bent_fit.batches, noise_model.roles) for each in both)
    assert found.nrmse.mean() < 1.1 * found.floor.mean() < 1.5 * found.floor.mean() < without.nrmse.mean()
    (batch,) = bent_fit.batches  # whole, as where a cause is asked for that acts in some only
    whole, astray = (
        begun_from(model_of(each, noise_model), (), batch, noise_model.roles, batch.samples).cost.sum() for each in both
    )
    assert whole < 1.15 * bent_fit.values < 1.3 * bent_fit.values < astray


@pytest.mark.slow
def test_forecasts_of_motions_larger_than_those_of_training_are_bent_where_their_first_fifth_asks_for_it(
    bridge_setting: Setting, bent_fit: Fit
) -> None:
    """As where those of training are too quiet to tell; a recording from a linear model stays so."""
    setting, quiet = bridge_setting, made_linear(bent_fit)
    motion = Motion.of_states(
        states_along(setting.short, setting.searched), setting.nominal.followed_shapes
    ).displacement
    setting = replace(setting, geometries=geometries_of(setting.nominal, 0.4 * motion, rng()))  # as of quieter ones
    evidence = Evidence(quiet, posterior_of((quiet,), ()), setting.noise_model, setting.noise_model, ())
    model, roles = Scorer.of(setting, evidence).model(quiet), setting.noise_model.roles
    (batch,) = bent_fit.batches
    own, linear = (forecast(each, (batch,), roles) for each in (model, replace(model, bent=())))
    assert own.nrmse.mean() < 1.1 * own.floor.mean() < 1.5 * own.floor.mean() < linear.nrmse.mean()
    straight = predicted(replace(model, bent=()), batch, roles)
    again = predicted(model, replace(batch, data=straight, whole=None), roles)
    bent = predicted(replace(model, hypothesis=bent_fit.hypothesis, bent=()), batch, roles)
    off, apart = (np.abs(each - straight).max(axis=1) / setting.noise_model.sigma for each in (again, bent))
    assert off.max() < 0.5 < 5.0 < apart.max()  # initial states are a little nearer to rest than those that moved it
    assert is_bent(model, batch, roles).all()
    assert not is_bent(model, replace(batch, data=straight, whole=None), roles).any()
    scorer = Scorer.of(setting, evidence)
    assert not scorer.model(bent_fit).bent  # the recordings have shown it
    (tested,) = scorer.test
    linear_one = replace(tested, data=predicted(replace(model, bent=()), tested, scorer.roles), whole=None)
    assert scorer.bent_in(quiet) == tested.names
    other = replace(scorer, test=(linear_one,))
    assert other.bent_in(quiet) == scorer.bent_in(bent_fit) == ()
    assert scorer.forecast(quiet) is scorer.forecast(quiet)  # made once, of its own recordings alone
    assert other.forecast(quiet).energy != scorer.forecast(quiet).energy != scorer.forecast(quiet, 0.0).energy


@pytest.mark.slow
def test_what_was_recorded_is_scored_not_what_was_fitted(bridge_setting: Setting) -> None:
    """A fit's own batches, straightened or not, have the same forecasts."""
    setting = bridge_setting
    item = replace(setting.short, batches=setting.lengths.whole)
    (batch,) = columns_of(batches_of(setting.dataset, "train"), setting.measured)
    model = model_of(item, setting.noise_model)
    found = [
        forecast(model, (each,), setting.noise_model.roles).energy for each in (batch, batch.less(0.1 * batch.data))
    ]
    assert found[0] == found[1]


@pytest.mark.slow
def test_geometry_is_taken_away_where_the_recordings_show_it_and_nowhere_else() -> None:
    """The same two cases: a bridge that is geometrically exact, and one that its user made linear."""
    for seed, rich in ((61000, True), (61000, False)):
        config = BlindConfig(structure="bridge", noise=0.01, train=2, test=1, duration=7.99, rich=rich)
        setting = setting_of(blind_case(seed, config).dataset)
        begun = reference_fits_of(
            setting.nominal_hypothesis,
            setting.nominal_hypothesis.centre,
            setting.lengths,
            setting.noise_model,
            setting.short,
        )
        assert begun is not None
        ground, lengths = straighten(begun, begun.whole, setting.lengths, setting.noise_model, setting.geometries)
        assert any(ground.hypothesis.nominal.geometry is geometry for geometry in setting.geometries) == rich
        assert (lengths is setting.lengths) != rich
        # Noise as the recordings tell it is right to some 5 %.
        assert ground.whole.chi2 < 1.15 * ground.whole.values
