"""A modal model that stands for the structure in the user's simulation, and when it is called wrong."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.blind_cases import SENSORS, BlindConfig, blind_case
from benchmarks.blind_cases.case import as_recorded
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring, SensorGain, StiffnessChange
from fe_models.causes.laws import force_laws
from fe_models.errors import InputError
from fe_models.files.dataset_file import save_dataset
from fe_models.files.models import load_model
from fe_models.files.structure_file import save_structure
from fe_models.linear import ModalModel
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.simulation import FreeConfig, simulate_free
from fe_models.structure import Damping, Structure
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.fitting.forecast_score import ForecastModel, predicted
from hybrid.diagnosis.learned.gain import hybrid_gain
from hybrid.diagnosis.learned.learning import learning_preset
from hybrid.diagnosis.nominal.modal_model import modal_model_of
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.observed.observations import modes_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.batches import batches_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from scripts.diagnose import app

RATE = 10.0
# Damped mode by mode: what a modal model can say. The chain's own dashpots couple its modes.
CHAIN = replace(four_dof(), dashpots=(), damping=Damping(modal_ratios=(0.03, 0.02, 0.02, 0.015)))
OWN = natural_modes(linearise(CHAIN), 4)
BRIDGE_RATE, LOWPASS = 100.0, 30.0
BRIDGE_SENSORS = tuple(Sensor(f"a{node}", node, "y", "acceleration", "m/s^2") for node in (5, 9, 15, 19, 22, 26))
FREE = 1e4  # of initial states: so large that no prior is felt, whatever coordinates it is in


def given(dataset: Dataset, modal: ModalModel) -> Dataset:
    return replace(dataset, assumptions=replace(dataset.assumptions, modal_model=modal))


def contaminated(share: float, seed: int = 0) -> ModalModel:
    """The chain's modes with that relative error of frequencies and shapes, as in `benchmarks.chain`."""
    factors = 1 + share * np.random.default_rng(seed).standard_normal((5, 4))
    shapes = OWN.shapes.copy()
    shapes[OWN.dofs.free] *= factors[:4]
    return replace(OWN, omega=OWN.omega * factors[4], shapes=shapes)


def recorded(truth: Structure, train: int = 5) -> Dataset:
    """Noisy free vibrations of ``truth``, whose user believes in the chain."""
    rng, config = np.random.default_rng(0), BlindConfig(train=train, test=2, duration=30.0)
    start = rng.standard_normal((2, train + 2, 4))
    run = FreeConfig(30.0, RATE, 0.02)
    motion = simulate_free(linearise(truth), start[0], start[1], run, force_laws(truth), progress=False)
    clean = np.stack([motion.shown(s) for s in SENSORS], axis=-1)
    return as_recorded(CHAIN, SENSORS, clean, (), config, rng).dataset


def softened() -> Structure:
    return CHAIN.with_effects(StiffnessChange((2,), 0.7))


def both_models(dataset: Dataset, modal: ModalModel) -> tuple[NominalModel, NominalModel]:
    nominal = nominal_model_of(dataset)
    found = modal_model_of(nominal, given(dataset, modal))
    assert found is not None
    return nominal, found


def forecast_of(nominal: NominalModel, dataset: Dataset, theta: FloatArray | None = None) -> FloatArray:
    hypothesis = Hypothesis(nominal)
    noise_model = NoiseModel(dataset.sensors, dataset.sampling_rate, np.ones(len(dataset.sensors)))
    model = ForecastModel(
        hypothesis, hypothesis.centre if theta is None else theta, FREE**2 * np.eye(hypothesis.states)
    )
    return predicted(model, batches_of(dataset, "train")[0], noise_model.roles)


def noise(model: Structure, rate: float, sensors: tuple[Sensor, ...], lowpass: float | None = None) -> Dataset:
    data = np.random.default_rng(1).standard_normal((2, 300, len(sensors)))
    return Dataset(model, rate, sensors, (Recording("r", data),), lowpass)


@pytest.mark.parametrize("order", [(0, 1, 2, 3), (2, 0, 3, 1)])
def test_own_modal_model_of_the_chain_forecasts_as_the_chain_does_however_calibrated(order: tuple[int, ...]) -> None:
    dataset, which = noise(CHAIN, RATE, SENSORS), list(order)
    modal = replace(OWN, omega=OWN.omega[which], damping_ratio=OWN.damping_ratio[which], shapes=OWN.shapes[:, which])
    nominal, own = both_models(dataset, modal)
    theta = 0.1 * np.random.default_rng(2).standard_normal(len(nominal.spread))
    for factors in (np.zeros_like(theta), theta):
        wanted, found = (forecast_of(each, dataset, factors) for each in (nominal, own))
        np.testing.assert_allclose(found, wanted, atol=1e-7 * np.abs(wanted).max())
    np.testing.assert_array_equal(nominal.spread, own.spread)


def test_own_modal_model_of_the_bridge_forecasts_as_the_bridge_does() -> None:
    dataset = noise(bridge(), BRIDGE_RATE, BRIDGE_SENSORS, LOWPASS)
    nominal, own = both_models(dataset, natural_modes(linearise(bridge()), 20))
    assert own.size == nominal.size < 20  # modes far above the low-pass are not followed
    wanted, found = (forecast_of(each, dataset) for each in (nominal, own))
    # ill-conditioned: six sensors, eleven modes
    np.testing.assert_allclose(found, wanted, atol=1e-5 * np.abs(wanted).max())


def test_scale_and_sign_of_shapes_mean_nothing_also_under_force_laws() -> None:
    stiffened = CHAIN.with_effects(CubicSpring((2,), "x", 0.01))
    dataset = noise(stiffened, RATE, SENSORS)
    wrong = contaminated(0.03)
    scaled = replace(wrong, shapes=wrong.shapes * [2.0, -0.1, 1e3, 5.0])
    (_, one), (_, other) = (both_models(dataset, modal) for modal in (wrong, scaled))
    assert one.laws
    np.testing.assert_allclose(np.abs(one.basis), np.abs(other.basis), rtol=1e-12)
    wanted, found = (modes_of(Hypothesis(nominal), np.zeros(len(nominal.spread)), RATE) for nominal in (one, other))
    np.testing.assert_allclose(found.frequencies, wanted.frequencies, rtol=1e-9)
    np.testing.assert_allclose(np.abs(found.shapes), np.abs(wanted.shapes), rtol=1e-6, atol=1e-9)


def test_modes_are_those_of_the_file() -> None:
    wrong = replace(contaminated(0.03), damping_ratio=np.array([0.01, 0.02, 0.03, 0.04]))
    _, nominal = both_models(noise(CHAIN, RATE, SENSORS), wrong)
    found = modes_of(Hypothesis(nominal), np.zeros(len(nominal.spread)), RATE)
    np.testing.assert_allclose(found.frequencies, wrong.frequencies, rtol=1e-6)
    np.testing.assert_allclose(found.ratios, wrong.damping_ratio, rtol=1e-6)
    shapes = wrong.shapes[wrong.dofs.free]
    np.testing.assert_allclose(np.abs(found.shapes), np.abs(shapes) / np.abs(shapes).max(axis=0), atol=1e-9)


def test_stiffness_moves_frequencies_of_a_frame_by_its_half_however_rough_the_shapes() -> None:
    own = natural_modes(linearise(bridge()), 10)
    rough = own.shapes * (1 + 0.05 * np.random.default_rng(0).standard_normal(own.shapes.shape))
    nominal, modal = both_models(noise(bridge(), BRIDGE_RATE, BRIDGE_SENSORS, LOWPASS), replace(own, shapes=rough))
    theta = np.zeros((2, len(modal.spread)))
    theta[1, [i for i, part in enumerate(nominal.parts) if part.quantity == "stiffness"]] = np.log(1.01)
    before, after = (modes_of(Hypothesis(modal), one, BRIDGE_RATE).frequencies for one in theta)
    np.testing.assert_allclose(after / before, np.sqrt(1.01), rtol=1e-3)  # the whole structure is 1 % stiffer


@pytest.mark.parametrize("change", ["twice", "still", "many"])
def test_shapes_that_depend_on_each_other_are_refused(change: str) -> None:
    shapes = OWN.shapes.copy()
    if change == "twice":
        shapes[:, 2] = 3 * shapes[:, 1]
    if change == "still":
        shapes[:, 2] = 0.0
    modal = replace(OWN, shapes=shapes)
    if change == "many":
        modal = ModalModel(
            np.append(OWN.omega, 2.5), np.full(5, 0.01), np.column_stack([shapes, shapes[:, 0]]), OWN.dofs
        )
    with pytest.raises(InputError, match=r"modal_model: the . shapes that are used depend on each other"):
        setting_of(given(recorded(CHAIN), modal))


def test_damping_ratios_stand_for_a_structure_that_says_nothing_of_damping() -> None:
    data = recorded(CHAIN)
    bare = replace(data, model=replace(CHAIN, damping=Damping()))
    np.testing.assert_allclose(setting_of(given(bare, OWN)).nominal.own_ratios, OWN.damping_ratio, rtol=1e-9)
    wrong = replace(OWN, damping_ratio=np.full(4, 0.5))
    np.testing.assert_allclose(setting_of(given(data, wrong)).nominal.own_ratios, OWN.damping_ratio, rtol=1e-9)


def test_own_modal_model_changes_nothing() -> None:
    found = diagnose(given(recorded(CHAIN), OWN))
    assert found.verdict is Verdict.NOTHING_WRONG
    assert found.findings == ()
    assert any("forecasts as its structure does" in note for note in found.notes)


def test_contaminated_modal_model_is_the_finding() -> None:
    wrong = contaminated(0.03)
    found = diagnose(given(recorded(CHAIN), wrong))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location, finding.parameters) == ("modal_model", {}, {})
    assert finding.probability > 0.99
    assert finding.explains > 0.99
    assert len(finding.recordings) == 7
    ratio = wrong.omega / OWN.omega - 1
    assert f"frequencies by {ratio.min():+.1%} to {ratio.max():+.1%}" in finding.sentence
    assert "damping" not in finding.sentence
    baseline, extended = found.scores["baseline"]["measured"], found.scores["extended"]["measured"]
    assert baseline is not None
    assert extended is not None
    assert extended < 1.05 * found.noise_floor < 0.5 * baseline
    np.testing.assert_allclose(found.observations.nominal.frequencies, wrong.frequencies, rtol=1e-6)
    np.testing.assert_allclose(found.observations.observed.frequencies, OWN.frequencies, rtol=3e-3)
    before, after = (np.std(found.example.measured - y) for y in (found.example.nominal, found.example.extended))
    assert before > 5 * after  # the picture shows the modal model's forecast
    assert found.extended.effects == ()


@pytest.mark.slow
def test_wrong_modal_model_and_hidden_stiffness_are_both_found() -> None:
    found = diagnose(given(recorded(softened()), contaminated(0.03)))
    assert found.verdict is Verdict.EXPLAINED
    assert {finding.cause.kind for finding in found.findings} == {"modal_model", "stiffness_change"}
    assert all(finding.probability > 0.9 for finding in found.findings)
    assert all(finding.explains > 0.05 for finding in found.findings)
    assert [effect.kind for effect in found.extended.effects] == ["stiffness_change"]
    assert found.scores["extended"]["measured"] == pytest.approx(found.noise_floor, rel=0.05)


@pytest.mark.slow
def test_weak_cause_is_not_named_beside_a_wrong_modal_model() -> None:
    case = recorded(CHAIN)
    faulty = SensorGain("a1", 1.029)  # tells in 1500 samples, but noise is 3 %
    parts = tuple(replace(r, data=faulty.apply(r.data, [s.name for s in SENSORS], RATE)) for r in case.recordings)
    found = diagnose(given(replace(case, recordings=parts), contaminated(0.03)))
    assert [finding.cause.kind for finding in found.findings] == ["modal_model"]
    assert any(note.startswith("significant, but too weak") and "a1 shows" in note for note in found.notes)


@pytest.mark.slow
def test_modal_model_off_by_no_more_than_is_normal_is_calibration() -> None:
    near = contaminated(0.003)  # frequencies follow 1 % of stiffness by 0.5 %
    found = diagnose(given(recorded(CHAIN), near))
    assert found.verdict is Verdict.NOTHING_WRONG
    baseline = found.scores["baseline"]["measured"]
    assert baseline is not None
    assert baseline > 1.2 * found.noise_floor  # as it is, it forecasts worse
    assert any("not that of its structure" in note for note in found.notes)
    found = diagnose(given(recorded(softened()), near))
    assert [finding.cause.kind for finding in found.findings] == ["stiffness_change"]


@pytest.mark.slow
def test_measured_modes_of_a_structure_that_is_wrong_are_not_called_wrong() -> None:
    measured = natural_modes(linearise(softened()), 4)
    found = diagnose(given(recorded(softened()), measured))
    assert found.verdict is Verdict.NOTHING_WRONG
    assert any("leave modal_model out to have the structure diagnosed" in note for note in found.notes)
    hardened = softened().with_effects(CubicSpring((1,), "x", 0.5))
    found = diagnose(given(recorded(hardened, train=3), measured))
    assert {finding.cause.kind for finding in found.findings} == {"stiffness_change", "cubic_spring"}


def test_damping_that_couples_modes_is_reported_of_a_modal_model_that_lacks_it() -> None:
    case = blind_case(21, BlindConfig(train=5, test=2, duration=30.0))
    found = diagnose(given(case.dataset, natural_modes(linearise(four_dof()), 4)))
    (finding,) = found.findings
    assert "(no damping between modes, which the structure's dashpots couple)" in finding.sentence


@pytest.mark.slow
def test_hybrid_trains_on_a_modal_model_and_speaks_for_no_place() -> None:
    data = given(recorded(CHAIN, train=2), contaminated(0.03))
    config = learning_preset(data.model)
    gain = hybrid_gain(data, diagnose(data), replace(config, training=replace(config.training, epochs=1)))
    assert gain.nominal is not None
    assert gain.extended is not None
    assert not any("speak" in note for note in gain.notes)


@pytest.mark.slow
def test_script_takes_the_file_and_names_it(tmp_path: Path) -> None:
    save_structure(CHAIN, tmp_path / "chain.toml")
    dataset = save_dataset(given(recorded(CHAIN, train=3), contaminated(0.03)), tmp_path, "chain.toml")
    done = CliRunner().invoke(app, [str(dataset), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert report["verdict"] == "explained"
    assert [finding["kind"] for finding in report["findings"]] == ["modal_model"]
    assert any("avoid 100% of what the modal model gets wrong" in note for note in report["notes"])
    assert "use the structure's own modes" in done.output
    assert isinstance(load_model("extended_model.toml", tmp_path / "out"), Structure)
