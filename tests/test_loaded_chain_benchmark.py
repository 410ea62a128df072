"""The benchmark of the chain under known loads: its true equations against Exudyn, and its rows."""

import numpy as np
import pytest
import torch

from benchmarks.chain import NOISE, oracle
from benchmarks.loaded_chain import BEGIN, SAMPLES, LoadedScore, loaded_dataset, rows
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.modes import natural_modes
from hybrid.training.forecast_comparison import compare
from hybrid.training.scoring import nrmse


@pytest.mark.slow
def test_the_true_equations_follow_the_simulation_under_loads_to_the_noise() -> None:
    """Given whole records of four sensors, at all twelve channels: 2 % above the noise itself, for what they cost."""
    torch.set_num_threads(1)
    dataset, clean = loaded_dataset(1.0, natural_modes(linearise(four_dof()), 4), 5)
    (test,) = dataset.select("test")
    assert clean.shape == test.data.shape == (1, SAMPLES, 12)
    assert test.skipped == BEGIN
    assert all(len(load.values) == SAMPLES for load in test.loads)
    noise = test.data - clean
    assert noise.std() == pytest.approx(NOISE * np.concatenate([r.data for r in dataset.recordings]).std(), rel=0.05)
    found = compare(oracle(dataset, 1.0), dataset, SAMPLES, 1)
    assert found is not None
    assert found.whole_record is not None
    floor = nrmse(clean, test.data).mean()
    assert nrmse(found.whole_record.forecast.channels, test.data).mean() < 1.02 * floor


def test_rows_hold_the_training_against_the_true_equations() -> None:
    first, _, whole, *_ = rows(LoadedScore(1.0, 0.021, 0.3, 0.02, 0.008, 0.007, 0.9, 60.0))
    assert first.section == "chain under loads, k_n = 1"
    assert (first.value, first.peer, first.peer_value, first.aim) == (0.021, "true equations", 0.02, "0.0220")
    assert (whole.value, whole.peer_value) == (0.008, 0.007)
