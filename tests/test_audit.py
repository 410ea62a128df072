"""The audit: nested sampling of a known integral, closed forms beside it, ranks that are even or not."""

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.audit import by_modes, by_series
from benchmarks.audit.chain import COUNT, Problem
from benchmarks.audit.nested import Target, sampled
from benchmarks.audit.ranks import DRAWS, PASSES, draws_of, ranks_of, uniform
from benchmarks.audit.run import Compared, evidence_table, rank_table
from fe_models.arrays import FloatArray
from scripts.benchmark import app

SIZE = 3


def normal_target(bound: float = np.inf) -> Target:
    """Return a density of which 3 times as much as of a normal one of independent values lies below a ``bound``."""
    width = np.array([0.5, 1.0, 2.0])

    def log_density(theta: FloatArray) -> float:
        return float(np.log(3) - 0.5 * np.sum((theta / width) ** 2) - np.log(width).sum() - 1.5 * np.log(2 * np.pi))

    lower, upper = np.full(SIZE, -np.inf), np.array([bound, np.inf, np.inf])
    return Target("three", log_density, lower, upper, np.zeros(SIZE), np.diag(width**2), np.log(3.0), 0.0)


@pytest.mark.parametrize(("bound", "evidence"), [(np.inf, np.log(3.0)), (0.0, np.log(1.5))])
def test_nested_sampling_finds_a_known_integral(bound: float, evidence: float) -> None:
    found = sampled(normal_target(bound), seed=0, live=60)
    assert found.error < 0.3
    assert abs(found.evidence - evidence) < 3 * found.error


@pytest.mark.parametrize(("search", "module"), [("modes", by_modes), ("series", by_series)])
def test_closed_forms_are_those_of_the_density_where_a_fit_is_tight(search: str, module: ModuleType) -> None:
    """By Laplace's formula for all parameters at once: the program integrates over some of them in another way."""
    for target in module.case(Problem.of(search), 1, 1):
        at_best = target.log_density(target.mean)
        assert at_best is not None
        volume = 0.5 * len(target.mean) * np.log(2 * np.pi) + 0.5 * np.linalg.slogdet(target.covariance)[1]
        assert target.closed == pytest.approx(at_best + volume, abs=0.3)  # slopes that change; of some hundred nats


def test_a_density_is_nothing_where_the_chain_does_not_stand() -> None:
    target = by_modes.case(Problem.of("modes"), 1, 1)[0]
    far = target.mean.copy()
    far[COUNT:] = -800.0  # no mass is left
    assert target.log_density(far) is None


@pytest.mark.parametrize(("narrower", "passes"), [(1.0, True), (2.0, False)])
def test_ranks_are_even_where_posteriors_are_right_alone(narrower: float, passes: bool) -> None:
    """A normal value, measured with noise of the size of its prior; 300 draws show an error stated as half as large."""
    rng, found = np.random.default_rng(0), list[list[int]]()
    for _ in range(300):
        truth = rng.standard_normal(1)
        seen = truth + rng.standard_normal(1)
        found.append(ranks_of(["size"], truth, draws_of(seen / 2, np.eye(1) / 2 / narrower**2, rng))["size"])
    (own,) = uniform({"size": found})
    assert sum(own.counts) == 300
    assert (own.p > PASSES) is passes
    assert 0 <= min(min(row) for row in found) <= max(max(row) for row in found) <= DRAWS


def test_tables_say_what_agrees() -> None:
    compared = [
        Compared("modes", 1, "nothing", 6, 10.0, 10.2, 0.2, 900, 0.0),
        Compared("modes", 1, "mass", 7, 12.0, 9.0, 0.2, 900, 0.0),  # first in closed form alone
        Compared("series", 1, "nothing", 7, 5.0, 5.1, 0.2, 900, 0.0),
        Compared("series", 1, "mass", 8, 4.0, 4.1, 0.2, 900, 0.0),
    ]
    rows = {line.split(" | ")[0].removeprefix("| "): line for line in evidence_table(compared)}
    assert "50 % (1/2), 9-91 % | 100 % (2/2), 34-100 % | 75 % (3/4)" in rows["closed form within 1 of log Z"]
    assert rows["same first cause, cases"] == "| same first cause, cases | 0 % (0/1) | 100 % (1/1) | 50 % (1/2) |"
    assert rows["largest of these"].startswith("| largest of these | +3.00 | -0.10 | +3.00")
    assert "| no |" in rank_table({"by modes": uniform({"mass": [[0]] * 100})}, 100)[-1]


@pytest.mark.slow
def test_the_command_keeps_what_is_done_and_prints_both_tables(tmp_path: Path) -> None:
    words = ["--audit", "--quick", "--out", str(tmp_path)]
    first = CliRunner().invoke(app, words)
    assert first.exit_code == 0, first.output
    assert "| fits | 2 | 2 | 4 |" in first.output
    assert "by series: stiffness" in first.output
    again = CliRunner().invoke(app, words)
    assert again.stdout == first.stdout
