"""What a hybrid model has left to learn: sensors put right, learned forces held against the laws of the list."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from typer.testing import CliRunner

from benchmarks.blind_cases import SENSORS, BlindConfig, blind_case
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring, Effect, HarmonicForce, SensorDelay, SensorDrift, SensorGain, StiffnessChange
from fe_models.errors import InputError
from fe_models.files.dataset_file import save_dataset
from fe_models.recordings import Dataset, Recording
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.config import Config, places_preset
from hybrid.diagnosis.learned import gain, learning
from hybrid.diagnosis.learned.forces import PlaceForce
from hybrid.diagnosis.learned.learning import corrected, learn, learning_preset
from hybrid.diagnosis.learned.projection import Projected, location_of, project
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.training.preparation import prepare
from hybrid.training.scoring import nrmse
from scripts.diagnose import app

RNG = np.random.default_rng(0)
U, V = RNG.standard_normal((2, 2000))


@pytest.mark.parametrize(
    ("word", "force"),
    [
        ("spring", -0.3 * U),
        ("dashpot", 2 * V),
        ("cubic_spring", 0.5 * U**3),
        ("quadratic_damper", V * np.abs(V)),
        ("coulomb_friction", 0.1 * np.sign(V)),
        ("gap_stop", 5 * np.maximum(-U - 0.45 * np.abs(U).max(), 0)),
    ],
)
def test_each_law_is_recognised_by_its_own_word(word: str, force: np.ndarray) -> None:
    found = project(PlaceForce("node 1 x to ground", U, V, force, 1.0))
    assert next(iter(found.laws)) == word
    assert found.laws[word] > 0.99
    assert found.rest < 0.01


def test_what_no_law_explains_stays_with_the_net() -> None:
    found = project(PlaceForce("node 1 to node 2 x", U, V, RNG.standard_normal(2000), 0.5))
    assert found.rest > 0.95
    assert found.location == {"nodes": [1, 2], "direction": "x"}


def test_places_have_the_locations_of_the_contract() -> None:
    assert location_of("node 3 x to ground") == {"node": 3, "direction": "x"}
    assert location_of("node 3 to node 4 x") == {"nodes": [3, 4], "direction": "x"}


@pytest.mark.parametrize("fault", [SensorGain("a1", -1.3), SensorDelay("a1", 0.07), SensorDrift("a1", 0.2)])
def test_faults_of_sensors_are_taken_back(fault: SensorGain | SensorDelay | SensorDrift) -> None:
    """But for what a delay's spline gets wrong, which is worst at the ends."""
    time = np.arange(200) / 10
    data = np.stack([np.cos(time), np.sin(2 * time)], axis=-1)
    names = ["x4", "a1"]
    back = fault.inverse().apply(fault.apply(data, names, 10.0), names, 10.0)
    np.testing.assert_allclose(back[5:-5], data[5:-5], atol=2e-3)
    assert np.abs(fault.apply(data, names, 10.0) - data)[5:-5].max() > 0.05


def test_faults_of_one_sensor_are_taken_back_where_they_act_the_last_first() -> None:
    """A gain of 1.5 acts before a drift comes on top: the drift goes first, in whatever order they were found."""
    case = blind_case(14, BlindConfig(train=2, test=1, duration=5.0)).dataset
    names, rate = [sensor.name for sensor in case.sensors], case.sampling_rate
    first, drift = case.recordings[0], SensorDrift("a1", 0.1)
    spoilt = drift.apply(SensorGain("a1", 1.5).apply(first.data, names, rate), names, rate)
    given = replace(case, recordings=(replace(first, data=spoilt), *case.recordings[1:]))
    findings = tuple(
        Finding(cause, {}, 1.0, 0.5, (first.name,), (), "") for cause in (SensorGain("a1", 1.5), SensorDrift("a1", 0.1))
    )
    for found in (findings, findings[::-1]):
        back = corrected(given, found)
        for recording, clean in zip(back.recordings, case.recordings, strict=True):
            np.testing.assert_allclose(recording.data, clean.data, atol=1e-12)


def test_chains_learn_at_places() -> None:
    case = blind_case(14, BlindConfig(train=1, test=1, duration=5.0)).dataset
    assert learning_preset(case.model) == places_preset()
    assert corrected(case, ()) == case


def quick(_: object) -> Config:
    preset = places_preset()
    return replace(preset, training=replace(preset.training, epochs=3, first_horizon=80))


@pytest.mark.slow
def test_hybrid_has_less_left_to_learn_on_the_extended_structure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Through the script: scores, shares and what was learned where; the place and the law are those of the finding."""
    monkeypatch.setattr(learning, "learning_preset", quick)
    case = blind_case(14, BlindConfig(("stiffness_change",), size=0.8, train=3, test=1, duration=15.0)).dataset
    path = save_dataset(case, tmp_path, "four_dof")
    done = CliRunner().invoke(app, [str(path), "--out", str(tmp_path / "out"), "--hybrid"])
    assert done.exit_code == 0, done.output
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    nominal, extended = report["hybrid"]["nominal"], report["hybrid"]["extended"]
    assert extended["learned_share"] < 0.2 * nominal["learned_share"]
    assert report["scores"]["hybrid"] == {word: extended[word] for word in ("measured", "held_out")}
    assert extended["measured"] < 1.5 * report["noise_floor"]
    first = report["learned_residual"]["nominal"][0]
    assert first["location"] == {"nodes": [3, 4], "direction": "x"}
    assert report["findings"][0]["location"] == {"element": 4}
    assert next(iter(first["laws"])) == "spring"
    assert any("speaks for the finding" in note for note in report["notes"])
    assert "Hybrid model on the extended structure" in done.output


@pytest.mark.parametrize("ends", [(2, 3), (3, 2)])
@pytest.mark.parametrize("cause", [CubicSpring((2, 3), "x", 1.0), StiffnessChange((3,), 0.7)])
def test_what_was_learned_speaks_for_the_finding_whichever_end_of_a_spring_was_drawn_first(
    ends: tuple[int, int], cause: Effect
) -> None:
    chain = four_dof()
    springs = [replace(item, nodes=ends) if item.nodes == (2, 3) else item for item in chain.elements]
    law = "cubic_spring" if isinstance(cause, CubicSpring) else "spring"
    place = Projected({"nodes": list(ends), "direction": "x"}, 0.9, {law: 0.8}, 0.1)
    found = (Finding(cause, {}, 1.0, 0.5, ("r",), (), ""),)
    said = gain._evidence((place,), found, replace(chain, elements=tuple(springs)))
    assert said.endswith("speaks for the finding")


def test_structure_with_laws_of_its_own_starts_as_it_is() -> None:
    """Its cubic spring must not be calibrated away as a linear one; the dashpots couple the modes, and are kept whole.

    0.5 % is what the propagator leaves with two substeps.
    """
    config = FreeConfig(duration=15.0, sampling_rate=10.0)
    state = RNG.standard_normal((2, 2, 4))
    motion = simulate_free(four_dof(0.5), state[0], state[1], config, progress=False)
    true = np.stack([motion.shown(s) for s in SENSORS], axis=-1)
    dataset = Dataset(four_dof(0.5), 10.0, SENSORS, (Recording("r", true),))
    prepared = prepare(dataset, places_preset())
    shapes = prepared.modal.shapes[prepared.modal.dofs.free]
    q, q_dot = (torch.tensor(np.linalg.solve(shapes, part.T).T, dtype=torch.float32) for part in state)
    with torch.no_grad():
        shown = prepared.model.forecast(prepared.model.scale_state(q, q_dot), true.shape[1]).channels.numpy()
    assert nrmse(shown, true).max() < 5e-3


def test_force_that_depends_on_time_is_refused_and_said() -> None:
    """A window does not tell when in its recording it begins: the report then goes without the hybrid there."""
    case = blind_case(14, BlindConfig(train=2, test=1, duration=10.0)).dataset
    forced = replace(case, model=four_dof().with_effects(HarmonicForce(2, "x", 1.0, 0.5)))
    with pytest.raises(InputError, match="depends on time"):
        learn(forced, quick(None))
