"""Leaving recordings out: every one is forecast once, by a fit that never saw what is forecast."""

from dataclasses import replace

import numpy as np

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.arrays import FloatArray
from fe_models.measurement import lowpassed
from fe_models.recordings import Recording
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.fitting.crossvalidation import as_recordings, folds_of
from hybrid.diagnosis.fitting.forecast_score import ForecastModel, ForecastScore
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.outcome.noisier import with_own_noise
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.recorded.batches import batches_of, columns_of, measured_columns
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis

CASE = blind_case(3, BlindConfig(train=6, test=0, duration=20.0)).dataset
MEASURED = measured_columns(CASE)
NOISE_MODEL = NoiseModel(tuple(CASE.sensors[i] for i in MEASURED), CASE.sampling_rate, np.full(4, 0.03))


def test_every_recording_is_forecast_by_a_fit_to_the_others_and_to_its_first_fifth() -> None:
    batches = columns_of(batches_of(CASE, "train"), MEASURED)
    hypothesis = Hypothesis(nominal_model_of(CASE))
    whole = fit(hypothesis, hypothesis.centre, batches, NOISE_MODEL)
    assert whole is not None
    searched = replace(NOISE_MODEL, sigma=10 * NOISE_MODEL.sigma)
    folds = folds_of(CASE, MEASURED, searched)
    assert folds is not None
    unseeing = folds.unseeing(whole)
    found = folds.forecast([ForecastModel(one.hypothesis, one.theta, np.eye(8)) for one in unseeing], NOISE_MODEL)
    names = {r.name for r in CASE.recordings}
    tested = [{name for batch in fold for name in batch.names} for fold in folds.tests]
    assert found.nrmse.shape == found.floor.shape == (6, 5)
    assert set().union(*tested) == names
    for one, own in zip(unseeing, tested, strict=True):
        seen = {name: batch.samples for batch in one.batches for name in batch.names}
        assert seen == dict.fromkeys(names, 201) | dict.fromkeys(own, 41)  # of those that are forecast the first fifth
    most = 0.02 * whole.chi2 / whole.values  # in what counts as noise, of a hundred times its energy
    assert max(one.chi2 / one.values for one in unseeing) < most


def test_a_recording_that_alone_a_cause_spares_is_forecast_without_it() -> None:
    """Left out, it leaves none where the cause does not act, and was forecast as if it acted everywhere."""
    config = BlindConfig(("stiffness_change",), size=0.6, train=4, test=0, changed=1, duration=20.0)
    case = blind_case(860, config)
    setting = setting_of(case.dataset)
    places = {c.key: c for c in setting.candidates()}
    (truth,) = case.truth
    hypothesis = setting.nominal_hypothesis.adding(places[f"{truth.kind} {truth.location}"])
    (batch,) = setting.lengths.whole
    batches = (replace(batch.take([0]), off=(0,)), batch.take([1, 2, 3]))
    item = fit(hypothesis, hypothesis.centre, batches, setting.noise_model)
    folds = folds_of(case.dataset, setting.measured, setting.searched)
    assert item is not None
    assert folds is not None
    found = Scorer(setting, setting.noise_model, (), folds).forecast(item)
    own = list(setting.measured)
    over = found.nrmse[:, own].mean(axis=1) / found.floor[:, own].mean(axis=1)
    assert over.max() < 1.15  # as near as counts; the nominal model leaves 16 times the floor


def test_a_recording_in_which_alone_a_cause_acts_tells_of_it_by_its_first_fifth() -> None:
    """Left out whole, it was forecast as if nothing had changed."""
    case = blind_case(861, BlindConfig(("stiffness_change",), size=0.6, train=4, test=0, changed=3, duration=20.0))
    setting = setting_of(case.dataset)
    (truth,) = case.truth
    places = {c.key: c for c in setting.candidates()}
    hypothesis = setting.nominal_hypothesis.adding(places[f"{truth.kind} {truth.location}"])
    (batch,) = setting.lengths.whole
    batches = (replace(batch.take([0, 1, 2]), off=(0,)), batch.take([3]))
    item = fit(hypothesis, hypothesis.centre, batches, setting.noise_model)
    folds = folds_of(case.dataset, setting.measured, setting.searched)
    assert item is not None
    assert folds is not None
    found, own = Scorer(setting, setting.noise_model, (), folds).forecast(item), list(setting.measured)
    over = found.nrmse[:, own].mean(axis=1) / found.floor[:, own].mean(axis=1)
    assert over.max() < 1.15  # as near as counts


def test_recordings_are_reported_as_forecast_wrongly_only_where_they_were_kept_for_testing() -> None:
    wrong, floor = np.ones((6, 5)), np.ones((6, 5))
    wrong[4] = 1.2  # beyond what is near the floor
    found, setting = ForecastScore(wrong, floor, 0.0, 0.0), setting_of(CASE)
    tests = batches_of(CASE, "train")
    assert Scorer(setting, NOISE_MODEL, tests, None).wrong_in(found) == (tests[0].names[4],)
    assert Scorer(setting, NOISE_MODEL, (), folds_of(CASE, MEASURED, NOISE_MODEL)).wrong_in(found) == ()


def test_all_recordings_tell_together_whether_noise_was_low_passed() -> None:
    """One of four has noise that was not: alone in its fold it would be weighed otherwise than in the fits."""
    white = np.random.default_rng(0).standard_normal((4, 2000, 5))
    noise = [*(lowpassed(data, 10.0, 3.0) for data in white[:3]), white[3]]
    recordings = tuple(Recording(f"r{number}", data[None]) for number, data in enumerate(noise))
    folds = folds_of(replace(CASE, recordings=recordings, lowpass=3.0), MEASURED, NOISE_MODEL)
    assert folds is not None
    assert [batch.share for fold in folds.tests for batch in fold] == [0.6] * 4  # 3 Hz of 5


def test_test_recordings_make_folds_unnecessary() -> None:
    tested = replace(CASE, recordings=(*CASE.recordings[1:], replace(CASE.recordings[0], role="test")))
    assert folds_of(tested, (0,), NOISE_MODEL) is None
    assert as_recordings(tested) == (tested, [])


def test_single_recording_is_halved_and_a_short_one_scored_as_it_is() -> None:
    one = replace(CASE, recordings=CASE.recordings[:1])
    halves, notes = as_recordings(one)
    assert [r.data.shape[1] for r in halves.recordings] == [100, 100]
    assert "half" in notes[0]
    short = replace(one, recordings=(replace(one.recordings[0], data=one.recordings[0].data[:, :50]),))
    same, notes = as_recordings(short)
    assert [r.role for r in same.recordings] == ["train", "test"]
    assert "what was fitted" in notes[0]


def test_a_test_recording_that_is_only_noisier_holds_nothing_that_training_does_not_show() -> None:
    case = blind_case(5, BlindConfig(train=4, test=2, duration=20.0)).dataset
    setting = setting_of(case)
    base = fit(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths.whole, setting.noise_model
    )
    assert base is not None
    (tests,) = setting.test_recordings()
    first, second = tests.names
    rng, sigma = np.random.default_rng(2), np.append(setting.noise_model.sigma, 0)[: tests.data.shape[2]]
    noisy, other = tests.data.copy(), tests.data.copy()
    noisy[1] += 3 * sigma * rng.standard_normal(noisy[1].shape)
    other[1] *= np.where(np.arange(other.shape[2]) == 0, 1.2, 1.0)  # another gain

    def scored(data: FloatArray) -> tuple[float, list[str]]:
        """Return how far forecasts are above the noise floor, and the notes."""
        scorer = Scorer(setting, setting.noise_model, (replace(tests, data=data),), None)
        knowing, notes = with_own_noise(scorer, base)
        found = knowing.forecast(base)
        return knowing.error(found) / knowing.floor(found), notes

    over, (note,) = scored(noisy)
    assert over < VERDICT.max_near_ratio
    assert f"({second})" in note
    over, notes = scored(other)
    assert over > VERDICT.max_near_ratio
    assert notes == []
    over, (note,) = scored(np.stack([noisy[1], other[1]]))
    assert over > VERDICT.max_near_ratio
    assert f"({first})" in note
