"""Blind cases under unknown and known forces and base motion: against other solvers, and what is recorded of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lsim

from benchmarks.blind.cases import default_words
from benchmarks.blind.judging import judge
from benchmarks.blind_cases import OUTSIDE, BlindCase, BlindConfig, Excitation, blind_case, save_case
from benchmarks.blind_cases.ambient import UnknownForces, ambient_motion
from benchmarks.blind_cases.chain_motion import driven
from benchmarks.blind_cases.far import TrueFactor
from benchmarks.blind_cases.kinds import kinds_of
from benchmarks.blind_cases.known_forces import MARGIN, Driving, drawn_driving
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import AddedMass, CubicSpring, LoadDelay, LoadGain, MassChange, PointDamper, StiffnessChange
from fe_models.causes.laws import force_laws
from fe_models.damping import full_damping
from fe_models.drive import drive_of
from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset
from fe_models.modes import natural_modes
from fe_models.recordings import QUANTITIES, Dataset, Load, Sensor
from fe_models.simulation import FreeConfig, simulate_driven
from hybrid.diagnosis.outcome.calibration import Calibrated
from tests.blind_results import EXPLAINED, HEAVY, case_of, diagnosis, finding

SHORT = BlindConfig(train=2, test=1, duration=30.0)
MEASURED, BASE = replace(SHORT, excitation="measured"), replace(SHORT, excitation="base")
AMBIENT = BlindConfig(excitation="ambient", train=2, duration=60.0)


def recordings(case: BlindCase) -> FloatArray:
    return np.concatenate([recording.data for recording in case.dataset.recordings])


def test_unknown_forces_move_a_damped_chain_as_in_another_solver() -> None:
    """By scipy's state space with first-order hold, of the same forces; a dashpot couples the modes."""
    structure = four_dof().with_effects(PointDamper((2, 3), "x", 0.4), AddedMass(2, 0.5))
    linear = linearise(structure)
    forces = UnknownForces(((1, "x"), (4, "x")), np.array([1.0, 0.3]), 1.0, seed=3)
    sensors = tuple(Sensor(quantity, 2, "x", quantity, "1") for quantity in QUANTITIES)
    rate, duration = 20.0, 30.0
    found = ambient_motion(linear, natural_modes(linear, 4), forces, sensors, duration, rate)
    M, C, K = linear.mass.toarray(), full_damping(linear), linear.stiffness.toarray()
    A = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    B = np.vstack([np.zeros((4, 2)), np.linalg.inv(M)[:, [0, 3]]])
    slowest = np.min(-np.linalg.eigvals(A).real)
    values = forces.values(round(2 * rate / slowest) + len(found), rate)
    _, _, x = lsim((A, B, np.eye(8), np.zeros((8, 2))), values, np.arange(len(values)) / rate)
    expected = np.column_stack([x[:, 1], x[:, 5], x @ A[5] + values @ B[5]])[-len(found) :]
    # Both are exact but for rounding, and for where the first sample of the force counts, which has died away.
    np.testing.assert_allclose(found, expected, atol=1e-2 * np.abs(expected).max(axis=0).min())
    np.testing.assert_allclose(found[-100:], expected[-100:], atol=1e-3 * np.abs(expected).max(axis=0).min())


@pytest.mark.parametrize("excitation", ["measured", "base"])
def test_known_forces_move_a_nonlinear_chain_as_in_exudyn(excitation: Excitation) -> None:
    config = replace(SHORT, excitation=excitation)
    driving = drawn_driving(config, 4, np.random.default_rng(2))
    structure = four_dof().with_effects(CubicSpring((1, 2), "x", 0.5), AddedMass(2, 0.5))
    found = driven(structure, linearise(structure), driving, config, force_laws(structure))
    for number, item in enumerate(driving):
        drive = drive_of(structure, item.recorded(10.0).all, 10.0)
        other = simulate_driven(structure, drive, FreeConfig(sampling_rate=10.0, step=0.02), progress=False)
        for quantity in QUANTITIES:
            own, expected = getattr(found, quantity)[number], getattr(other, quantity)
            # Steps of 0.005 s of order 2, and fast forces: a knock of one second.
            np.testing.assert_allclose(own, expected, atol=1e-3 * np.abs(expected).max())


@pytest.mark.parametrize(("config", "known"), [(MEASURED, "loads"), (BASE, "base")])
def test_what_is_known_stands_in_the_dataset(config: BlindConfig, known: str, tmp_path: Path) -> None:
    case = blind_case(5, replace(config, kinds=("cubic_spring",), noise=0.0))
    for recording in case.dataset.recordings:
        assert recording.excitation == "measured"
        assert [bool(recording.loads), bool(recording.base)] == [known == "loads", known == "base"]
        assert {len(values) for values in recording.driving} == {301}
    kept = load_dataset(save_case(case, tmp_path))
    np.testing.assert_allclose(kept.recordings[0].driving[0], case.dataset.recordings[0].driving[0])
    assert kept.sensors[0].reference == ("base" if known == "base" else "absolute")


def test_accelerometers_on_a_moving_base_show_its_motion_too() -> None:
    """As Exudyn has it of the base motion that stands in the dataset."""
    case = blind_case(6, replace(BASE, noise=0.0))
    recording = case.dataset.recordings[0]
    u = recording.data[0]
    structure = four_dof()
    drive = drive_of(structure, recording.base, 10.0)
    expected = simulate_driven(structure, drive, FreeConfig(sampling_rate=10.0, step=0.02), progress=False)
    for column, sensor in enumerate(case.dataset.sensors):
        np.testing.assert_allclose(u[:, column], expected.shown(sensor), atol=2e-3 * np.abs(u[:, column]).max())
    assert (
        np.abs(expected.shown(case.dataset.sensors[1]) - expected.acceleration[:, 0]).max()
        > 0.1 * np.abs(u).max(axis=0).min()
    )


def test_a_load_that_is_recorded_late_shows_what_acted_before() -> None:
    """Half a sample late, and at twice its size: a straight line through the samples shows both exactly."""
    course = np.linspace(3.0, 18.0, 41 + 2 * MARGIN)
    faults = (LoadDelay((2, "x"), 0.05), LoadGain((2, "x"), 2.0), LoadGain((1, "x"), 9.0))
    (load,) = Driving(loads=(Load(2, "x", course),)).recorded(10.0, faults).loads
    np.testing.assert_allclose(load.values, 2 * (course[MARGIN:-MARGIN] - 0.5 * (course[1] - course[0])), rtol=1e-12)


@pytest.mark.slow
def test_a_fault_of_a_load_leaves_the_motion_as_it_is_and_acts_where_it_should() -> None:
    config = replace(MEASURED, kinds=("load_gain",), acts="one", size=1.0, noise=0.0)
    seed = next(seed for seed in range(9, 40) if len(_differing(seed, config)))  # the faulty load is recorded there
    assert _differing(seed, config) == ["r02"]
    case, plain = blind_case(seed, config), blind_case(seed, replace(config, kinds=()))
    np.testing.assert_array_equal(recordings(case), recordings(plain))
    (cause,) = case.truth
    assert isinstance(cause, LoadGain)
    assert abs(cause.factor - 1) == pytest.approx(0.5)


def _differing(seed: int, config: BlindConfig) -> list[str]:
    """Return the recordings whose loads a fault has changed."""
    cases = [blind_case(seed, item).dataset.recordings for item in (config, replace(config, kinds=()))]
    return [
        a.name
        for a, b in zip(*cases, strict=True)
        if any(not np.array_equal(one.values, other.values) for one, other in zip(a.loads, b.loads, strict=True))
    ]


def test_unknown_forces_leave_no_course_and_the_same_seed_the_same_case() -> None:
    case, again = (blind_case(7, replace(AMBIENT, kinds=("stiffness_change",), acts="one")) for _ in range(2))
    np.testing.assert_array_equal(recordings(case), recordings(again))
    assert {recording.excitation for recording in case.dataset.recordings} == {"ambient"}
    assert not case.dataset.is_loaded
    assert case.recordings == ("r02",)
    thirds = np.array_split(recordings(case), 3, axis=1)
    assert 0.5 < thirds[2].std() / thirds[0].std() < 2.0  # it goes on; a free decay falls to a tenth


@pytest.mark.slow
def test_wind_and_traffic_on_the_bridge() -> None:
    config = BlindConfig(structure="bridge", excitation="ambient", tier="far", train=1, duration=20.0)
    case = blind_case(8, replace(config, kinds=("added_mass",)))
    assert recordings(case).shape == (1, 2001, 8)
    assert case.dataset.lowpass == 30.0
    assert np.all(recordings(case).std(axis=(0, 1)) > 0)


@pytest.mark.parametrize("kind", kinds_of("four_dof", "free") + OUTSIDE)
def test_every_kind_is_simulated_in_the_chain(kind: str) -> None:
    config = BlindConfig(kinds=(kind,), size=1.0, train=1, test=0, duration=5.0)
    case = blind_case(5, config)
    assert [cause.kind for cause in case.truth] + list(case.outside) == [kind]
    assert np.isfinite(case.dataset.recordings[0].data).all()


def test_what_each_excitation_may_hide() -> None:
    assert "load_delay" in default_words(MEASURED)
    assert "time_integration" not in default_words(BASE)
    assert "nothing" in default_words(AMBIENT)
    assert "hysteretic_spring" not in default_words(AMBIENT)
    with pytest.raises(InputError, match="kinds cubic_spring are unknown"):
        blind_case(1, replace(AMBIENT, kinds=("cubic_spring",)))
    with pytest.raises(InputError, match="excitation = base of the bridge; expected free or ambient, or the chain"):
        blind_case(1, replace(BASE, structure="bridge"))


def test_groups_that_are_far_from_their_drawing_are_rightly_named_beside_the_hidden_cause() -> None:
    """Each spring of the chain is a group by itself; two of them may be off together, all three are no group."""
    hidden, local = AddedMass(4, 0.5), AddedMass(3, 0.5)
    drawn = Dataset(four_dof(), 10.0, (), ())
    case = replace(case_of(hidden), dataset=drawn, factors=(TrueFactor("stiffness", {"elements": [1, 2]}, 0.8),))
    named = [finding(cause, 0.99) for cause in (StiffnessChange((1,), 0.8), StiffnessChange((2,), 0.8))]
    found = judge(case, diagnosis(EXPLAINED, named[0], finding(hidden, 0.97), *named[1:]))
    assert found.first
    assert not found.confidently_wrong
    assert found.probabilities == ((0.97, True),)
    assert judge(case, diagnosis(EXPLAINED, finding(local, 0.95), *named)).confidently_wrong
    assert judge(case_of(hidden), diagnosis(EXPLAINED, named[0])).confidently_wrong
    for other in (StiffnessChange((3,), 0.8), StiffnessChange((1, 2), 0.8), MassChange((1,), 1.1)):
        assert judge(case, diagnosis(EXPLAINED, finding(other, 0.99))).confidently_wrong


def test_factors_of_groups_are_held_against_the_true_ones() -> None:
    """Not those that the hidden cause changes as well, nor elements by themselves."""
    drawn = Dataset(four_dof(), 10.0, (), ())
    factors = tuple(TrueFactor("stiffness", {"elements": [number]}, 0.8) for number in (1, 2, 3))
    case = replace(case_of(StiffnessChange((3,), 0.5)), dataset=drawn, factors=factors)
    calibrated = (
        Calibrated("stiffness", {"element": 1}, 0.81, 0.01),
        Calibrated("stiffness", {"element": 2}, 0.85, 0.01),
        Calibrated("stiffness", {"element": 3}, 0.4, 0.01),
        Calibrated("damping", {"modes": [1]}, 1.4, 0.01),
    )
    found = diagnosis(EXPLAINED, calibration=calibrated)
    assert judge(case, found).groups == (True, False)
    assert judge(case_of(HEAVY), found).groups == ()
