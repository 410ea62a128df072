"""A change between recordings, alone or beside a cause that acts in all of them."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.judging import judge
from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring, StiffnessChange
from fe_models.causes.candidate import SupportCandidate
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.contest.stages import fits_unalike
from hybrid.diagnosis.fitting.forecast_score import forecast, model_of, without
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kinds", "seed"),
    [
        (("point_damper", "support_spring"), 150004),  # each alone leaves much: seen before the change only
        (("stiffness_change", "added_mass"), 150001),  # a calibration far off would hide the first
        (("stiffness_change", "cubic_spring"), 150018),  # a force law comes, which recordings feel by their size
        (("harmonic_force", "stiffness_change"), 170003),  # what no single cause explains is no noise
        (("coulomb_friction", "stiffness_change"), 200006),  # a first step cut short tells nothing of the next
        (("harmonic_force", "stiffness_change"), 190003),  # before the change two places of the force are alike
        (("sensor_gain", "cubic_spring"), 170002),  # no amounts but their order tells the change
        (("added_mass", "point_damper"), 170011),  # segments alone would sort a recording wrongly
    ],
    ids=lambda value: "+".join(value) if isinstance(value, tuple) else "",
)
def test_a_cause_beside_a_change_is_named_with_it(kinds: tuple[str, str], seed: int) -> None:
    case = blind_case(seed, BlindConfig(kinds, tier="off", changed=4))
    found = diagnose(case.dataset)
    marks = judge(case, found)
    assert found.verdict is Verdict.EXPLAINED
    assert set(marks.named) == set(marks.truth)
    assert all(marks.within)  # 10 % or two standard deviations
    lasting, comes = (next(f for f in found.findings if f.cause.kind == kind) for kind in kinds)
    assert lasting.recordings == tuple(recording.name for recording in case.dataset.recordings)
    assert len(set(comes.recordings) - set(case.recordings)) <= 1  # a weak law hardly shows in a quiet recording


@pytest.mark.slow
def test_a_faint_change_is_found_beside_a_law_that_forecasts_well_in_all_recordings() -> None:
    case = blind_case(860001, BlindConfig(("added_mass",), structure="bridge", tier="off", changed=2))
    found = diagnose(case.dataset)
    assert found.verdict is Verdict.EXPLAINED  # a cubic spring that never changes forecasts training to 1.06 at most
    assert judge(case, found).named == judge(case, found).truth


@pytest.mark.slow
def test_friction_that_comes_is_found_where_a_machine_in_one_recording_would_forecast_as_well() -> None:
    case = blind_case(860006, BlindConfig(("coulomb_friction",), structure="bridge", tier="off", changed=2))
    found = diagnose(case.dataset)
    assert found.verdict is Verdict.EXPLAINED
    assert judge(case, found).named == judge(case, found).truth


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "kind"), [(861, "added_mass"), (862, "added_mass")])
def test_a_change_is_no_machine_that_begins_anew_in_each_segment(seed: int, kind: str) -> None:
    """Its two entries of each segment's initial state take up noise: a machine (0.94, 1.00) was named for a mass."""
    config = BlindConfig((kind,), size=0.15, tier="off", changed=4, train=8, test=2, duration=30.0)
    case = blind_case(seed, config)
    found = diagnose(case.dataset)
    assert judge(case, found).named == judge(case, found).truth
    assert [finding.recordings for finding in found.findings] == [case.recordings]


@pytest.mark.slow
def test_a_change_of_a_structure_that_has_a_force_law_of_its_own_is_detected() -> None:
    sensors = tuple(Sensor(f"x{node}", node, "x", "displacement", "m") for node in (1, 2, 3, 4))
    before = four_dof().with_effects(CubicSpring((2,), "x", 1.0))
    rng = np.random.default_rng(1)
    position, velocity = rng.standard_normal((2, 7, 4))
    motions = [
        simulate_free(structure, position, velocity, FreeConfig(20.0, 10.0), progress=False)
        for structure in (before, before.with_effects(StiffnessChange((3,), 0.85)))
    ]
    clean = [np.stack([m.channel(s.node, "x", "displacement") for s in sensors], axis=-1) for m in motions]
    data = np.concatenate([clean[0][:3], clean[1][3:]])
    data = data + 0.03 * data.std(axis=(0, 1)) * rng.standard_normal(data.shape)
    recordings = tuple(Recording(f"r{i}", part[None], "train" if i < 6 else "test") for i, part in enumerate(data))
    (finding,) = diagnose(Dataset(before, 10.0, sensors, recordings)).findings
    assert (finding.cause.kind, finding.cause.location) == ("stiffness_change", {"element": 3})
    assert finding.recordings == ("r3", "r4", "r5", "r6")


def test_what_only_test_recordings_show_is_unexplained() -> None:
    config = BlindConfig(("stiffness_change",), size=0.8, train=4, test=2, duration=30.0, changed=4)
    found = diagnose(blind_case(3, config).dataset)
    assert found.verdict is Verdict.UNEXPLAINED
    assert found.findings == ()
    assert any("test recordings do (r05, r06)" in note for note in found.notes)


@pytest.mark.slow
def test_a_support_that_gives_way_between_recordings_is_forecast_with_and_without() -> None:
    config = BlindConfig(("support_spring",), structure="bridge", rich=False, train=2, test=1, duration=4.0)
    setting = setting_of(blind_case(0, config).dataset)
    soft = next(c for c in setting.candidates() if isinstance(c, SupportCandidate))
    hypothesis = setting.nominal_hypothesis.adding(soft)
    batches = tuple(
        replace(batch.take([number]), off=(0,) * number) for batch in setting.lengths.whole for number in (0, 1)
    )
    item = fit(hypothesis, np.append(np.zeros(hypothesis.nuisances), soft.width), batches, setting.noise_model)
    assert item is not None
    model = model_of(item, setting.noise_model)
    with_it, without_it = (without(model, off) for off in ((), (0,)))
    assert [len(part[2]) for part in (with_it, without_it)] == [part[0].states for part in (with_it, without_it)]
    found = forecast(model, batches, setting.noise_model.roles)
    assert np.isfinite(found.nrmse).all()


@pytest.mark.slow
@pytest.mark.parametrize("samples", [60, 501])
def test_chance_hardly_leaves_recordings_unalike(samples: int) -> None:
    """Of nine recordings with 60 samples of four sensors 9 of 10 draws are more than a fifth apart."""
    setting = setting_of(blind_case(0, BlindConfig((), train=9, test=1)).dataset)
    item = fit(
        setting.nominal_hypothesis,
        np.zeros(setting.nominal_hypothesis.nuisances),
        setting.lengths.whole,
        setting.noise_model,
    )
    assert item is not None
    rng = np.random.default_rng(0)
    drawn = [replace(item, residuals=(rng.standard_normal((9, samples, 4)),)) for _ in range(1000)]
    assert sum(map(fits_unalike, drawn)) <= 6  # 1.4 expected at most; more than 6 in one of 2000


def test_a_fit_that_leaves_more_of_one_recording_than_of_the_others_fits_unalike() -> None:
    case = blind_case(0, BlindConfig((), train=9, test=1))
    setting = setting_of(case.dataset)
    item = fit(
        setting.nominal_hypothesis,
        np.zeros(setting.nominal_hypothesis.nuisances),
        setting.lengths.whole,
        setting.noise_model,
    )
    assert item is not None
    assert not fits_unalike(item)  # noise alone, nine recordings
    (part,) = item.residuals
    more = part * np.where(np.arange(len(part)) == 4, 1.15, 1.0)[:, None, None]  # 1.32 in its square
    assert fits_unalike(replace(item, residuals=(more,)))
