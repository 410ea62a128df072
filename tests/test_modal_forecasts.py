"""Forecasts of a diagnosis by modes, on a chain of five masses whose free decay is known in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fe_models as fe
from fe_models.arrays import FloatArray
from fe_models.causes.candidate import LawCandidate
from fe_models.causes.known import Channel
from fe_models.causes.places import Motion
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.discrepancy.forecasting import Forecaster, system_of_modes
from hybrid.diagnosis.discrepancy.law_fit import LawFit
from hybrid.diagnosis.discrepancy.recorded_motions import track_of
from hybrid.diagnosis.discrepancy.settling import settled
from hybrid.diagnosis.modal.all_candidates import all_candidates_of
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.modes_and_motion.forecasts import motion_forecasts_of
from hybrid.diagnosis.modes_and_motion.look import look_at
from hybrid.diagnosis.modes_and_motion.motion_fit import MotionFit, motion_by_claim
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel, SensorRoles
from hybrid.diagnosis.response.marching import respond
from tests.test_modal_evidence import SENSORS, chain
from tests.test_modal_report import RATE, decays

OFF = np.array([0.85, 1.15, 1.1, 0.9, 1.2])


def recorded(structures: dict[str, fe.Structure], tested: tuple[str, ...] = ()) -> fe.Dataset:
    """Return recordings of each structure, held against the drawn chain."""
    rng = np.random.default_rng(3)
    recordings = tuple(
        fe.Recording(name, decays(structure, rng), "test" if name in tested else "train")
        for name, structure in structures.items()
    )
    return fe.Dataset(chain(), RATE, SENSORS, recordings)


def nothing(what: str) -> None:
    """Hear what is done, and say nothing."""


@pytest.fixture(scope="module")
def far() -> tuple[fe.Dataset, MotionFit]:
    """A chain that is off by a fifth, and the motion as its groups explain it."""
    truth = chain(OFF)
    dataset = recorded({"a": truth, "b": truth, "c": truth}, ("c",))
    look = look_at(dataset, nothing)
    found = motion_by_claim(look.dataset, look.measured, look.drawn)
    assert found is not None
    return dataset, found


def test_a_structure_that_was_found_is_forecast_as_well_as_noise_lets_it(far: tuple[fe.Dataset, MotionFit]) -> None:
    """Noise of 1 % of each channel's rms; a chance of a tenth on the floor's own estimate of it."""
    dataset, found = far
    look = look_at(dataset, nothing)
    forecasts = motion_forecasts_of(dataset, look.nominal_fit, found)
    assert forecasts is not None
    own = dataset.select("test")[0].data[0]
    rest = own[len(own) // 5 :]
    noise = 0.01 * own.std(axis=0) / np.ptp(rest, axis=0)
    assert forecasts.floor == pytest.approx(noise.mean(), rel=0.1)
    assert forecasts.scores["extended"]["measured"] == pytest.approx(forecasts.floor, rel=0.1)
    assert forecasts.reach_noise
    before = forecasts.scores["baseline"]["measured"]
    assert before is not None
    assert before > 10 * forecasts.floor
    assert forecasts.unexplained < 1e-3


def test_modes_settle_where_the_recordings_have_them(far: tuple[fe.Dataset, MotionFit]) -> None:
    """From values that are a half per cent off: frequencies come back to a ten-thousandth, as 40 s of them tell."""
    dataset, found = far
    fit: ModalFit = found.fit
    nudged = fit.theta.copy()
    nudged[: len(found.measured.nominal.parts)] += 0.01 * np.array([1, -1, 1, 1, -1, 1, 1, -1, -1, 1])
    item = track_of(dataset, found.measured, replace(fit, theta=nudged))
    assert item is not None
    true = 2 * np.pi * np.sort(fe.natural_modes(chain(OFF), 5).frequencies)
    assert np.abs(item.spaces[0].omega / true - 1).max() > 1e-3
    again = settled(item, ())
    np.testing.assert_allclose(again.spaces[0].omega, true, rtol=2e-4)
    np.testing.assert_allclose(again.spaces[0].ratio, 0.01, atol=2e-4)


def test_modes_under_a_law_move_as_an_ode_solver_says(far: tuple[fe.Dataset, MotionFit]) -> None:
    _, found = far
    nominal, space = found.measured.nominal, found.track.spaces[0]
    law = cubic_beside(found)
    own = tuple(range(len(SENSORS)))
    roles = SensorRoles(SENSORS, own, NoiseModel(SENSORS, RATE, np.ones(len(SENSORS))))
    system = system_of_modes(space, nominal, roles, law)
    begun = np.concatenate([np.full(space.count, 0.02), np.zeros(space.count)])
    along = law.candidate.pull @ space.shapes

    def rate(t: float, x: FloatArray) -> FloatArray:
        q, v = x[: space.count], x[space.count :]
        force = law.theta[0] * float(along @ q) ** 3
        return np.concatenate([v, -(space.omega**2) * q - 2 * space.ratio * space.omega * v - along * force])

    times = np.arange(200) / RATE
    solved = solve_ivp(rate, (0.0, times[-1]), begun, t_eval=times, rtol=1e-9, atol=1e-12).y
    shown = solved.T @ system.C[0].T
    moved = respond(system, begun[None, None], len(times))[0, 0]
    free = respond(system_of_modes(space, nominal, roles, None), begun[None, None], len(times))[0, 0]
    assert np.abs(free - shown).max() > 0.1 * np.abs(shown).max()
    np.testing.assert_allclose(moved, shown, atol=2e-3 * np.abs(shown).max())  # of a table's and a step's errors


def cubic_beside(found: MotionFit) -> LawFit:
    """Return a hardening spring at the first mass, strong where all modes move by a fiftieth."""
    shapes = found.track.spaces[0].shapes
    states = np.random.default_rng(0).standard_normal((50, shapes.shape[1]))
    motion = Motion(states @ shapes.T, states @ shapes.T)
    channels = tuple(Channel(sensor.name, 1.0, 1.0) for sensor in SENSORS)
    every = all_candidates_of(found.measured.nominal, motion, channels)
    law = next(own for own in every if own.kind == "cubic_spring" and own.location == {"node": 1, "direction": "x"})
    assert isinstance(law, LawCandidate)
    return LawFit(law, np.array([2e6]), np.eye(1), 0.0, found.track)


def test_a_recording_of_each_state_is_forecast_by_its_own(far: tuple[fe.Dataset, MotionFit]) -> None:
    """Of two systems that of the recording itself is taken, though the other one is asked first."""
    dataset, found = far
    nominal, space = found.measured.nominal, found.track.spaces[0]
    own = tuple(range(len(SENSORS)))
    roles = SensorRoles(SENSORS, own, NoiseModel(SENSORS, RATE, np.full(len(SENSORS), 1e-3)))
    spaces = [replace(space, omega=space.omega * factor) for factor in (0.97, 1.0)]
    batch = Batch(np.stack([dataset.recordings[0].data[0]]), ("a",))
    both = Forecaster.of(spaces, nominal, None, [batch], roles).forecast(batch)
    alone = Forecaster.of(spaces[1:], nominal, None, [batch], roles).forecast(batch)
    np.testing.assert_allclose(both, alone, atol=1e-9 * np.abs(alone).max())


@pytest.mark.slow
def test_the_door_asks_modes_where_a_recording_is_of_another_structure() -> None:
    """Springs off by a fifth where 1 % is stated; the third lost a quarter in the last recording for training."""
    truth = chain(OFF)
    changed = truth.with_effects(fe.StiffnessChange((3,), 0.75))
    found = diagnose(recorded({"a": truth, "b": truth, "c": changed, "d": truth}, ("d",)))
    assert isinstance(found, ModalDiagnosis)
    assert (found.findings[0].cause.kind, found.findings[0].recordings) == ("stiffness_change", ("c",))
    assert found.findings[0].cause.location == {"element": 3}
    assert found.findings[0].probability > 0.9
    gain = found.findings[0].gain
    assert gain is not None
    assert gain > 0.99  # of the error of "c", a spring of which has lost a quarter
    floor = found.noise_floor
    assert floor is not None
    assert found.scores["extended"]["measured"] == pytest.approx(floor, rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("names", ["ab", "aab", "aabb"])
def test_a_change_is_forecast_that_no_other_recording_shows(names: str) -> None:
    """Before and after, without recordings for testing: what a fit to the others cannot know is in the modes of the
    first fifth.
    """
    truth = chain(OFF)
    both = {"a": truth, "b": truth.with_effects(fe.StiffnessChange((3,), 0.9))}
    found = diagnose(recorded({f"{name}{number}": both[name] for number, name in enumerate(names)}))
    assert isinstance(found, ModalDiagnosis)
    assert len(found.states) == 2
    floor, before, after = found.noise_floor, *(found.scores[own]["measured"] for own in ("baseline", "extended"))
    assert floor is not None
    assert before is not None
    assert before > 10 * floor
    assert after == pytest.approx(floor, rel=0.2)


@pytest.mark.slow
def test_a_spring_that_lost_a_fifth_between_two_recordings_of_a_nearly_right_chain() -> None:
    """Springs off by 1 %, as stated. Series have nothing to forecast the second recording with, and say that nothing
    explains it; modes and the motion do.
    """
    rng, drawn = np.random.default_rng(2), fe.four_dof()
    before = drawn.with_effects(
        *(fe.StiffnessChange((k,), float(np.exp(0.01 * rng.standard_normal()))) for k in (1, 2, 3))
    )
    after = before.with_effects(fe.StiffnessChange((2,), 0.8))
    both = [
        fe.simulate(own, sensors=["a1", "a2", "a3", "a4"], noise=0.03, motions=1, seed=200 + number)
        for number, own in enumerate((before, after))
    ]
    recordings = tuple(
        replace(own.recordings[0], name=name, role="train") for own, name in zip(both, ("before", "after"), strict=True)
    )
    found = diagnose(replace(both[0], model=drawn, recordings=recordings))
    assert (found.findings[0].cause.kind, found.findings[0].recordings) == ("stiffness_change", ("after",))
    assert found.findings[0].cause.location == {"element": 2}
    assert found.findings[0].parameters["factor"].value == pytest.approx(0.8, abs=0.005)


@pytest.mark.slow
def test_without_recordings_for_testing_each_is_forecast_by_the_others() -> None:
    truth = chain(OFF)
    dataset = recorded({"a": truth, "b": truth, "c": truth})
    look = look_at(dataset, nothing)
    found = motion_by_claim(look.dataset, look.measured, look.drawn)
    assert found is not None
    forecasts = motion_forecasts_of(dataset, look.nominal_fit, found)
    assert forecasts is not None
    assert forecasts.after.nrmse.shape == (3, len(SENSORS))
    assert forecasts.reach_noise
    assert motion_forecasts_of(recorded({"a": truth}), look.nominal_fit, found) is None
