"""What to measure next: which sensor or excitation would tell causes apart that the present sensors cannot."""

from dataclasses import replace
from functools import partial

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
from hybrid.diagnosis.next_measurement.by_series import next_by_series
from hybrid.diagnosis.next_measurement.hypotheses import Cause, Rivals, rivals_among
from hybrid.diagnosis.next_measurement.in_recordings import Sample, Surroundings, expected_in
from hybrid.diagnosis.next_measurement.information import Prediction
from hybrid.diagnosis.next_measurement.measurements import Measurement, noise_of, possible_sensors
from hybrid.diagnosis.next_measurement.recommendation import NextMeasurement, Option, recommended
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.config import MENTION
from hybrid.diagnosis.recorded.batches import batches_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.report import report_table, summary
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


MASSES = ("added_mass {'node': 4}", "added_mass {'node': 3}")
A1 = Sensor("a1", 1, "x", "acceleration", "m/s^2")


def next_of(posterior: Posterior, noise_model: NoiseModel) -> NextMeasurement:
    """Return what to measure next, where there is something to tell apart."""
    found = next_by_series(posterior, noise_model, noise_model.sensors)
    assert found is not None
    return found


def best_sensor(found: NextMeasurement) -> Option:
    """Return the best of the added sensors."""
    return next(option for option in found.options if option.measurement.kind == "sensor")


def test_accelerometers_are_offered_where_there_are_no_other_sensors() -> None:
    nominal = nominal_model_of(chain((A1,), AddedMass(4, 1.0), 100))
    assert [(s.node, s.quantity) for s in possible_sensors(nominal, (A1,))] == [(n, "acceleration") for n in (2, 3, 4)]


def test_two_causes_far_from_the_only_sensor_are_distinguished_by_one_near_them() -> None:
    """In a short record a sensor at one end says little about the other; advice says so, and by how much."""
    found = next_of(*two_fits(chain((X1,), AddedMass(4, 0.5), 100), MASSES))
    option = best_sensor(found)
    assert [cause.kind for cause in found.causes] == ["added_mass", "added_mass"]
    assert option.measurement.node in (3, 4)
    assert option.probability > 0.95
    assert found.now == pytest.approx(0.6)
    assert {item.measurement.kind for item in found.options} == {"sensor", "pull", "hammer"}


def test_promise_is_kept_by_the_sensor() -> None:
    """With the advised sensor fitted, too, the odds of the right cause are really such as were promised."""
    option = best_sensor(next_of(*two_fits(chain((X1,), AddedMass(4, 0.5), 100), MASSES)))
    at = option.measurement
    assert at.quantity is not None
    added = Sensor("new", at.node, "x", at.quantity, "m")
    better, _ = two_fits(chain((X1, added), AddedMass(4, 0.5), 100), MASSES)
    right, wrong = better.fits
    then = 1 / (1 + 0.4 / 0.6 * np.exp(-0.5 * (wrong.cost - right.cost)))
    assert then > 0.9


def test_twins_that_no_sensor_tells_apart_are_said_to_be_so() -> None:
    """The first spring joins the ground and node 1: losing stiffness there is a softer support of node 1."""
    keys = ("stiffness_change {'element': 1}", "support_spring {'node': 1, 'direction': 'x'}")
    found = next_of(*two_fits(chain((X1,), StiffnessChange((1,), 0.5), 200), keys))
    assert not found.options
    assert [cause.kind for cause in found.open] == ["support_spring"]
    (sentence,) = found.sentences
    assert sentence.startswith("no added sensor, pull or blow tells the stiffness change at element 1")


def test_places_that_move_alike_stay_open_whatever_is_measured() -> None:
    posterior, noise_model = two_fits(chain((X1,), AddedMass(4, 0.5), 100), MASSES, alike={MASSES[0]: 2})
    found = next_of(posterior, noise_model)
    assert [cause.location for cause in found.open] == [{"node": 2}]
    assert found.now == pytest.approx(0.3)
    assert 0.45 < best_sensor(found).probability < 0.75  # half of what is found if it is one of the two, all if not
    assert "none of these tells the added mass at node 4 from the added mass at node 2" in found.sentences[-1]


def test_without_a_rival_nothing_is_to_be_measured() -> None:
    posterior, noise_model = two_fits(chain((X1,), AddedMass(4, 0.5), 100), MASSES)
    alone = replace(posterior, probability=np.array([0.995, 0.005]))
    assert next_by_series(alone, noise_model, noise_model.sensors) is None


def test_what_a_present_sensor_leaves_open_is_what_a_second_one_like_it_would_show() -> None:
    """Channels that were fitted leave as much open as the fit has free numbers: the trace of its projection.

    16 initial values, and those shares of the parameters that the data tell rather than the prior. Half of the samples,
    drawn, tell such a sum of squares to a few per cent.
    """
    posterior, noise_model = two_fits(chain((X1,), AddedMass(4, 0.5), 200), MASSES)
    item = posterior.fits[0]
    sample = Sample.of(item)
    found = expected_in(item, (replace(X1, name="again"),), Surroundings(noise_model, 1.0, 1.0), sample)
    assert found is not None
    parts = [part for own in found for part in (own.by_theta, own.by_state)]
    free = sum(float(np.sum((part / NOISE) ** 2)) for part in parts) * sample.stands_for
    told = 1 - item.hypothesis.precision * np.diag(item.covariance)
    assert free == pytest.approx(16 + told.sum(), rel=0.1)


def predicted(*means: float) -> tuple[Prediction, ...]:
    """Return predictions of one value that differ in their means alone."""
    return tuple(Prediction(np.array([mean]), np.zeros((1, 1))) for mean in means)


def rivals(*weights: float) -> Rivals:
    """Return masses at nodes one after the other as rivals."""
    causes = tuple(Cause("added_mass", {"node": node}, own) for node, own in enumerate(weights, start=1))
    return Rivals(tuple(range(len(weights))), np.array(weights), 1.0, causes, np.ones(len(weights)), ())


def test_the_one_place_where_hypotheses_differ_is_the_one_to_measure() -> None:
    places = {Measurement("sensor", node, "x", "acceleration"): predicted(0.0, 9.0 * (node == 2)) for node in (1, 2, 3)}
    found = recommended(rivals(0.5, 0.5), {item: partial(tuple, own) for item, own in places.items()})
    assert [(option.measurement.node, round(option.probability, 2)) for option in found.options] == [(2, 1.0)]
    assert found.sentences == (
        "an accelerometer at node 2 in x would tell the added mass at node 1 from the added mass at node 2"
        " (expected probability of the right one: > 0.99; now 0.50)",
    )


def test_a_rival_that_the_best_measurement_leaves_open_is_named() -> None:
    at = Measurement("pull", 2, "x")
    found = recommended(rivals(0.5, 0.3, 0.2), {at: lambda: predicted(0.0, 9.0, 0.0)})
    assert [cause.location for cause in found.open] == [{"node": 3}]
    assert found.options[0].probability == pytest.approx(0.8, abs=0.02)  # 0.5 of 0.7 in the open pair, 0.3 for sure
    assert "would help to tell" in found.sentences[0]
    assert "from the added mass at node 3: look at the structure there" in found.sentences[1]


def test_rivals_are_those_with_another_cause_in_the_place_of_one() -> None:
    posterior, _ = two_fits(chain((X1,), AddedMass(4, 0.5), 100), MASSES)
    four, three = (fit.hypothesis.candidates[0] for fit in posterior.fits)
    several = [(four,), (three,), (four, three), ()]
    found = rivals_among(several, np.array([0.5, 0.3, 0.15, 0.05]))
    assert found is not None
    assert found.numbers == (0, 1)
    assert [cause.probability for cause in found.causes] == pytest.approx([0.65, 0.3])  # with another one beside, too
    np.testing.assert_allclose(found.weights, [0.65 / 0.95, 0.3 / 0.95])


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
    assert found.next_measurement is not None
    lines = summary(found).splitlines()
    assert sum(line.startswith("Measure this next: ") for line in lines) == 1
    assert report_table(found)["measure_next"]["probability_now"] == found.next_measurement.now


def test_added_sensors_are_as_noisy_as_the_present_ones_and_stand_where_something_moves() -> None:
    """One beside a support would else tell everything: its noise, in proportion to what it shows, would be nothing."""
    dataset = chain((X1,), AddedMass(4, 0.5), 100)
    stiff = nominal_model_of(replace(dataset, model=four_dof().with_effects(SupportSpring(4, "x", 1e9))))
    moving = replace(stiff, kept=3)  # without the mode of node 4 alone
    assert {sensor.node for sensor in possible_sensors(moving, ())} == {1, 2, 3}
    tilt = replace(X1, name="tilt", direction="rz")  # in radians, of which nothing follows for a displacement
    noise_model = NoiseModel((X1, replace(X1, name="v", quantity="velocity"), tilt), 10.0, np.array([0.02, 0.5, 1e-6]))
    added = (replace(X1, node=2), *(replace(X1, node=node, quantity="acceleration") for node in (3, 4)))
    noise = noise_of(
        added, np.array([1e-6, 1e-3, 4.0]), noise_model.sensors, noise_model.sigma, np.array([1.0, 10.0, 1.0])
    )
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
    assert over > MENTION.max_imperfect_ratio
    assert then < MENTION.max_helped_share * over
    assert not any("how they begin" in note for note in diagnose(case).notes)
