"""Advice: which added sensor would tell two causes apart that the present ones cannot."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import AddedMass, StiffnessChange, SupportSpring
from fe_models.causes.places import Motion
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.nominal_model import nominal_model_of
from hybrid.diagnosis.outcome.advice import Advice, advise, noise_of, possible_sensors
from hybrid.diagnosis.outcome.too_few import BETTER, MANY
from hybrid.diagnosis.recorded.batches import batches_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose

NOISE = 0.03


def chain(sensors: tuple[Sensor, ...], effect: StiffnessChange | AddedMass, samples: int) -> Dataset:
    """Return free motions of a chain with an effect, its springs as uncertain as its masses."""
    rng = np.random.default_rng(0)
    state = rng.standard_normal((2, 2, 4))
    config = FreeConfig(duration=samples / 10, sampling_rate=10.0)
    motion = simulate_free(four_dof().with_effects(effect), state[0], state[1], config, progress=False)
    data = np.stack([motion.shown(s) for s in sensors], axis=-1)
    data = data + NOISE * rng.standard_normal(data.shape)
    return Dataset(four_dof(), 10.0, sensors, tuple(Recording(f"r{i}", part[None]) for i, part in enumerate(data)))


def two_fits(
    dataset: Dataset, keys: tuple[str, str], alike: dict[str, int] | None = None
) -> tuple[Posterior, NoiseModel]:
    """Return a posterior that cannot tell the causes of two keys apart; ``alike``: their twins' node, by key."""
    nominal = nominal_model_of(dataset)
    measured = tuple(range(len(dataset.sensors)))
    batches = batches_of(dataset, "train")
    noise_model = NoiseModel(dataset.sensors, dataset.sampling_rate, np.full(len(measured), NOISE))
    unit = Motion(np.eye(4), np.eye(4))
    candidates = {c.key: c for c in all_candidates(nominal, dataset, unit, measured)}
    fits: list[Fit] = []
    for key in keys:
        twins = tuple({**candidates[key].location, "node": (alike or {})[own]} for own in {key} & set(alike or {}))
        hypothesis = Hypothesis(nominal).adding(replace(candidates[key], twins=twins))
        found = fit(hypothesis, hypothesis.centre, batches, noise_model)
        assert found is not None
        fits.append(found)
    return Posterior(tuple(fits), np.array([0.6, 0.4]), 1.0, 1.0), noise_model


X1 = Sensor("x1", 1, "x", "displacement", "m")


def test_possible_sensors_are_those_that_are_not_there() -> None:
    dataset = chain((X1,), AddedMass(4, 1.0), 100)
    places = [(s.node, s.quantity) for s in possible_sensors(nominal_model_of(dataset), dataset.sensors)]
    assert len(places) == 7
    assert (1, "displacement") not in places
    assert (1, "acceleration") in places


def test_two_causes_far_from_the_only_sensor_are_distinguished_by_one_near_them() -> None:
    """In a short record a sensor at one end says little about the other; advice says so, and by how much."""
    dataset = chain((X1,), AddedMass(4, 0.5), 100)
    posterior, noise_model = two_fits(dataset, ("added_mass {'node': 4}", "added_mass {'node': 3}"))
    (advice,) = advise(posterior, noise_model, noise_model.sensors)
    assert advice.kind == "added_mass"
    assert advice.sensor is not None
    assert advice.sensor.node in (3, 4)
    assert advice.then < 0.05
    assert f"node {advice.sensor.node} in x would tell" in advice.sentence


def test_promise_is_kept_by_the_sensor() -> None:
    """With the advised sensor fitted, too, the costs of the two really part by about what was promised."""
    dataset = chain((X1,), AddedMass(4, 0.5), 100)
    keys = ("added_mass {'node': 4}", "added_mass {'node': 3}")
    posterior, noise_model = two_fits(dataset, keys)
    (advice,) = advise(posterior, noise_model, noise_model.sensors)
    assert advice.sensor is not None
    better, _ = two_fits(chain((X1, advice.sensor), AddedMass(4, 0.5), 100), keys)
    before = posterior.fits[1].cost - posterior.fits[0].cost
    after = better.fits[1].cost - better.fits[0].cost
    promised = -2 * np.log(advice.then / (1 - advice.then) / (0.4 / 0.6))
    assert after - before > 0.5 * promised > 4  # half: the noise of the record, and a noise level that is estimated


def test_twins_that_no_sensor_tells_apart_are_said_to_be_so() -> None:
    """The first spring joins the ground and node 1: losing stiffness there is a softer support of node 1."""
    dataset = chain((X1,), StiffnessChange((1,), 0.5), 200)
    keys = ("stiffness_change {'element': 1}", "support_spring {'node': 1, 'direction': 'x'}")
    (advice,) = advise(*two_fits(dataset, keys), dataset.sensors)
    assert advice.sensor is None
    assert advice.then == pytest.approx(0.4)
    assert "no added sensor" in advice.sentence


def test_a_rival_at_two_places_that_move_alike_is_advised_on_once() -> None:
    """The second place is none of the fits': once it ended in a traceback."""
    keys = ("added_mass {'node': 4}", "added_mass {'node': 3}")
    (advice,) = advise(*two_fits(chain((X1,), AddedMass(4, 0.5), 100), keys, alike={keys[1]: 2}), (X1,))
    assert advice.rival_location == {"node": 3}


def test_another_kind_at_the_place_of_a_twin_is_not_taken_for_the_twin() -> None:
    keys = ("point_damper {'node': 4, 'direction': 'x'}", "support_spring {'node': 3, 'direction': 'x'}")
    posterior, noise_model = two_fits(chain((X1,), AddedMass(4, 0.5), 100), keys, alike={keys[0]: 3})
    other, twin = advise(posterior, noise_model, (X1,))
    assert (twin.rival, twin.rival_location["node"], twin.sensor) == ("point_damper", 3, None)
    assert (other.rival, other.rival_location["node"]) == ("support_spring", 3)
    assert other.sensor is not None


def test_sentence_of_little_help() -> None:
    sensor = Sensor("x2", 2, "x", "displacement", "m")
    little = Advice("added_mass", {"node": 4}, "added_mass", {"node": 3}, 0.4, sensor, 0.3)
    assert "hardly tells" in little.sentence
    assert "the latter's probability falls from 0.40 to 0.30" in little.sentence
    assert "would help" in replace(little, then=0.08).sentence
    assert "would tell" in replace(little, then=0.01).sentence


@pytest.mark.slow
def test_diagnosis_carries_the_advice() -> None:
    case = blind_case(15, BlindConfig(("stiffness_change",), size=0.6, train=3, test=1, duration=20.0)).dataset
    one = (0,)
    few = replace(
        case,
        sensors=tuple(case.sensors[i] for i in one),
        recordings=tuple(replace(r, data=r.data[:, :150, list(one)]) for r in case.recordings),
    )
    found = diagnose(few)
    doubted = [item for finding in found.findings for item in finding.alternatives if item.probability >= 0.05]
    assert len(found.advice) == min(len(doubted), 3)
    assert all(advice.sentence in found.notes for advice in found.advice)
    assert found.advice


def test_added_sensors_are_as_noisy_as_the_present_ones_and_stand_where_something_moves() -> None:
    """One beside a support would else tell everything: its noise, in proportion to what it shows, would be nothing."""
    dataset = chain((X1,), AddedMass(4, 0.5), 100)
    stiff = nominal_model_of(replace(dataset, model=four_dof().with_effects(SupportSpring(4, "x", 1e9))))
    moving = replace(stiff, kept=3)  # without the mode of node 4 alone
    assert {sensor.node for sensor in possible_sensors(moving, ())} == {1, 2, 3}
    tilt = replace(X1, name="tilt", direction="rz")  # in radians, of which nothing follows for a displacement
    noise_model = NoiseModel((X1, replace(X1, name="v", quantity="velocity"), tilt), 10.0, np.array([0.02, 0.5, 1e-6]))
    added = (replace(X1, node=2), *(replace(X1, node=node, quantity="acceleration") for node in (3, 4)))
    noise = noise_of(added, np.array([1e-6, 1e-3, 4.0]), noise_model, np.array([1.0, 10.0, 1.0]))
    np.testing.assert_allclose(noise, [0.02, 0.02 * 4.0, 0.02 * 4.0])  # 0.02: the median of 0.02, 0.05 and 1e-6


def test_too_few_sensors_are_reported_with_one_that_helps() -> None:
    """One accelerometer for half of a recording's fifth; all four sensors tell how it begins."""
    case = blind_case(1, BlindConfig((), train=1, test=0)).dataset
    column = next(i for i, sensor in enumerate(case.sensors) if sensor.name == "x4")
    (recording,) = case.recordings
    few = replace(
        case, sensors=(case.sensors[column],), recordings=(replace(recording, data=recording.data[..., [column]]),)
    )
    (note,) = (note for note in diagnose(few).notes if "how they begin" in note)
    assert "record longer, or with a sensor of the" in note
    over, then = (float(note.split(word)[1].split()[0]) for word in ("range, ", "bring it to "))
    assert over > MANY
    assert then < BETTER * over
    assert not any("how they begin" in note for note in diagnose(case).notes)
