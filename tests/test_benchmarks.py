"""The benchmark: its rows, its oracle, its ablations and the script, in tiny configurations."""

from dataclasses import replace
from inspect import signature
from pathlib import Path

import numpy as np
import pytest
import torch
from typer.testing import CliRunner

from benchmarks import ablations, ambient_frame, bridge, chain, cost, sampled_force
from benchmarks.command import benchmark
from benchmarks.row import Row, table
from benchmarks.run_kind import ALWAYS, HEEDED, RunKind
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.four_dof_data import paper_dataset
from fe_models.modes import natural_modes
from hybrid.estimation.forecast import forecast_windows
from hybrid.training.scoring import nrmse
from scripts.benchmark import app
from tests.hybrid_problems import chain_dataset, starting_model


def test_a_published_number_is_marked_as_one() -> None:
    lines = table([Row("a", "b", 0.5, "c", 2.0), Row("a", "b", 0.5, "c", 2.0, measured_peer=False)]).splitlines()
    assert lines[2] == "| a | b | 0.5 | c | 2 |  |"
    assert lines[3] == "| a | b | 0.5 | c (published) | 2 |  |"


def test_the_drawn_modal_model_is_wrong_as_the_papers_is() -> None:
    """3 % noise on frequencies and shapes: 4 % on average over many draws' 20 numbers would be one in a thousand."""
    true = natural_modes(linearise(four_dof()), 4)
    drawn = [chain.own_modal_model(np.random.default_rng(seed)) for seed in range(20)]
    errors = np.concatenate([np.append(one.omega / true.omega, one.shapes / true.shapes) - 1 for one in drawn])
    assert errors.std() == pytest.approx(0.03, abs=0.003)  # four standard errors of 400 numbers
    assert all((one.damping_ratio == 0.01).all() for one in drawn)


def test_the_oracle_follows_clean_motions_to_the_accuracy_of_its_integrator() -> None:
    """With noise a thousand times smaller than it expects less of, 50 s of a hardening chain: 1e-3 of the range."""
    dataset = paper_dataset(1.0, None, realisations=10, progress=False)
    truth = chain.clean_test_motions(1.0, realisations=10)
    model = chain.oracle(dataset, 1.0)
    model.encoder.noise_std.fill_(1e-3)  # type: ignore[operator]
    assert nrmse(forecast_windows(model, truth).channels, truth).max() < 2e-3


def test_costs_grow_with_what_is_asked_for() -> None:
    """What is kept for the gradient of twice as many steps is twice as much, to a fifth: constants are small."""
    calls: list[int] = []
    costs = cost.measure({"length": (200, 400)}, lambda: calls.append(1))["length"]
    assert len(calls) == 2
    assert costs[1].memory == pytest.approx(2 * costs[0].memory, rel=0.2)
    rows = cost.rows({"length": costs})
    assert [row.peer for row in rows] == ["linear from 200"] * 2
    assert rows[1].peer_value == pytest.approx(2 * costs[0].memory)


def test_costs_are_drawn(tmp_path: Path) -> None:
    point = cost.Cost(cost.Point(), 1.0, 2.0)
    sheet = cost.draw({"length": [point, replace(point, point=cost.Point(length=1000), seconds=2.0)]})
    assert sheet.save(tmp_path / "cost.png").stat().st_size > 10_000


def test_ablations_change_what_they_say() -> None:
    model = starting_model(chain_dataset())
    z = torch.randn(2, 8, generator=torch.Generator().manual_seed(0))
    before = model.decode(z, torch.zeros(2, 4))
    ablations.unchanged(model)
    assert torch.equal(model.decode(z, torch.zeros(2, 4)), before)
    ablations.add_net_to_decoder(model)
    assert not torch.allclose(model.decode(z, torch.zeros(2, 4)), before)
    ablations.leave_physics_out(model)
    assert bool((model.dynamics.physical == 0).all())


def test_rows_of_the_bridge_hold_the_hybrid_against_its_peers() -> None:
    def scores(value: float) -> dict[str, dict[str, float]]:
        return {
            role: {"nrmse_first_16_windows": value, "nrmse": 2 * value, "r2": 0.9} for role in ("measured", "held_out")
        }

    peers = {"realisation": scores(3.0), "expansion_4": scores(4.0), "expansion_10": scores(5.0)}
    bands = {"hybrid": {"measured": 0.88, "held_out": 0.8}}
    metrics = {"scores": {"hybrid": scores(1.0)}, "peers": peers, "bands": bands, "training": {"seconds": 60.0}}
    rows = bridge.rows(metrics, test=3)
    assert {row.section for row in rows} == {"bridge, test r3"}
    assert [(row.value, row.peer_value) for row in rows[:4]] == [(1.0, 3.0), (1.0, 3.0), (1.0, 4.0), (1.0, 5.0)]
    assert [(row.value, row.peer_value) for row in rows[4:8]] == [(2.0, 6.0), (2.0, 6.0), (2.0, 8.0), (2.0, 10.0)]
    assert [row.value for row in rows[8:]] == [0.9, 0.88, 0.8, 60.0]


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ("--only bridge", "--only bridge needs --recordings FOLDER"),
        ("--only speed --recordings .", "--recordings has no effect"),
        ("--blind 3 --rates 2", "--blind and --rates are different runs"),
        ("--blind 3 --quick", "--quick has no effect with --blind"),
        ("--rates 3 --noise 0.03", "--noise has no effect with --rates: it goes with --blind"),
        ("--certificate --seed 0", "--seed has no effect with --certificate"),
        ("--no-peers", "--no-peers has no effect in the table"),
        ("--blind 3 --step 0.001", "--step has no effect on the chain"),
    ],
)
def test_options_that_do_not_go_together_are_refused(options: str, told: str, tmp_path: Path) -> None:
    """In one line, before any work, also where a value that has no effect is the default one."""
    result = CliRunner().invoke(app, [*options.split(), "--out", str(tmp_path / "out")])
    assert result.exit_code == 2, result.output
    (line,) = result.stderr.splitlines()
    assert line.startswith(f"error: {told}")
    assert not (tmp_path / "out").exists()


def test_each_option_of_the_benchmark_belongs_to_a_run() -> None:
    """One that is forgotten in the table of `run_kind` would be refused everywhere."""
    known = ALWAYS.union(*HEEDED.values(), {kind.value[2:] for kind in RunKind})
    assert set(signature(benchmark).parameters) - {"context"} == known - {""}


def test_recordings_that_are_not_there_are_named_before_any_section(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["--recordings", str(tmp_path / "none")])
    assert result.exit_code == 2
    assert result.stderr.count("no such file; the bridge's recordings") == 4


def test_a_modal_model_that_is_not_there_is_named(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["--modal-model", str(tmp_path / "none.npz"), "--only", "speed"])
    assert result.exit_code == 2
    assert "none.npz" in result.output


@pytest.mark.slow
def test_a_sampled_force_is_as_far_off_as_its_course_between_the_samples() -> None:
    """What folds down onto the resonance at 0.1 of the rate has fallen as f^-8: (0.3 / 0.9)^8 = 1.5e-4 of what is
    there, and (0.4 / 0.9)^8 = 1.5e-3; a held force is late by half a sample, by 2 pi 0.1 / 2 = 0.31 of itself.
    """
    samples = sampled_force.QUICK_SAMPLES
    folded, wider, straight, held = (sampled_force.forecast_errors(case, samples) for case in sampled_force.CASES)
    assert 1.5e-4 / 3 < folded[0] < 3 * 1.5e-4  # lines of random size in the resonance, and what folds beside it
    assert 1.5e-3 / 3 < wider[0] < 3 * 1.5e-3
    assert held[0] == pytest.approx(0.31, rel=0.1)  # the motion is that of the resonance but for its quasi-static part
    assert straight[0] == pytest.approx(1 - np.sinc(0.1) ** 2, rel=0.3)  # what straight lines take off a force there
    assert all(errors[0] < errors[2] for errors in (folded, wider, straight, held))  # a strong spring multiplies it


@pytest.mark.slow
def test_a_storey_that_lost_stiffness_under_ambient_vibration_is_named() -> None:
    rows = {row.what: row.value for row in ambient_frame.rows(1)}
    assert rows["30 % of a storey lost: that storey named first (1 pairs)"] == 1.0
    assert rows["nothing lost: called changed by diagnose (1 pairs)"] == 0.0
    assert rows["shapes with a MAC of 0.99 and more (1 pairs)"] == 1.0
