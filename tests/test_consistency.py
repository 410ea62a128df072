"""Recordings of two structures are distinguished, those of one are all kept."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring
from fe_models.linear import ModalModel
from fe_models.recordings import Recording
from fe_models.simulated_recordings import simulate
from hybrid.config import places_preset
from hybrid.estimation.linear_calibration import Observer
from hybrid.identification.agreement import largest_agreeing_group
from hybrid.training.consistency import unexplained_shares
from hybrid.training.preparation import agreeing_recordings, prepare
from tests.hybrid_problems import MEASURED, SENSORS, STEP, chain_modes, off_chain, recorded

LENGTH = 100
OBSERVER = Observer(chain_modes(), [SENSORS[i] for i in MEASURED], STEP)


def changed_chain() -> ModalModel:
    """The same chain after a change: all its frequencies are another 30 % lower."""
    return replace(off_chain(), omega=0.7 * off_chain().omega)


def recording(modal: ModalModel, seed: int) -> Recording:
    return Recording(f"r{seed}", recorded(modal, 6, LENGTH, seed, noise=0.03))


def kept_of(*models: ModalModel) -> list[int]:
    recordings = tuple(recording(modal, seed) for seed, modal in enumerate(models))
    kept = agreeing_recordings(OBSERVER, recordings, MEASURED, LENGTH)
    return [i for i, each in enumerate(recordings) if each in kept]


@pytest.mark.parametrize("odd", [0, 3])
def test_the_one_of_four_that_differs_is_left_out(odd: int) -> None:
    models = [off_chain()] * 4
    models[odd] = changed_chain()
    assert kept_of(*models) == [i for i in range(4) if i != odd]


def test_recordings_of_one_structure_are_all_kept() -> None:
    assert kept_of(*[off_chain()] * 3) == [0, 1, 2]


def test_of_two_that_differ_nobody_knows_which_to_leave_out() -> None:
    assert kept_of(off_chain(), changed_chain()) == [0, 1]


def test_shares_tell_how_much_a_model_leaves_of_each_recording() -> None:
    """Its own noise (0.03^2) of the same structure, most of one whose frequencies differ by 30 %."""
    windows = [torch.tensor(recording(m, i).data[:, :, MEASURED]) for i, m in enumerate((off_chain(), changed_chain()))]
    shares = unexplained_shares(OBSERVER, windows)
    assert np.all(np.diag(shares) < 5e-3)
    assert shares[0, 1] > 0.5
    assert shares[1, 0] > 0.5


def test_groups_are_formed_by_their_worse_direction() -> None:
    """A model may explain a recording by chance; only if each explains the other do two agree."""
    one_way = np.array([[0.0, 0.1, 0.9], [0.9, 0.0, 0.9], [0.1, 0.1, 0.0]])
    assert largest_agreeing_group(one_way) == [0]
    chained = np.array([[0.0, 0.3, 0.7, 0.9], [0.3, 0.0, 0.3, 0.9], [0.7, 0.3, 0.0, 0.9], [0.9, 0.9, 0.9, 0.0]])
    assert largest_agreeing_group(chained) == [0, 1, 2]
    assert largest_agreeing_group(np.zeros((3, 3))) == [0, 1, 2]
    assert largest_agreeing_group(np.array([[0.0, 0.9, 0.9], [0.9, 0.0, 0.1], [0.9, 0.1, 0.0]])) == [1, 2]


def test_models_that_do_not_explain_their_own_recordings_contradict_none() -> None:
    """Of five motions of a chain with a cubic spring: what linear models of each left, and then one of another kind."""
    bent = np.array([[0.64, 0.71, 0.83], [0.99, 1.0, 0.99], [0.94, 0.82, 0.89]])
    assert largest_agreeing_group(bent) == [0, 1, 2]
    one_explains_itself = np.array([[0.15, 0.40, 0.73], [0.77, 0.59, 0.72], [0.83, 0.92, 0.89]])
    assert largest_agreeing_group(one_explains_itself) == [0, 1, 2]
    another = np.array([[0.1, 0.1, 0.9], [0.1, 0.1, 0.9], [0.9, 0.9, 0.1]])
    assert largest_agreeing_group(another) == [0, 1]


@pytest.mark.slow
def test_motions_of_one_chain_with_a_cubic_spring_are_all_kept() -> None:
    """A residual tied to places learns the spring; linear models explain neither their own motion nor others."""
    truth = four_dof().with_effects(CubicSpring((1,), "x", 0.5))
    data = simulate(truth, ["x4", "a1", "a3", "a4"], motions=6, duration=20.0, noise=0.03, seed=1).split(0.84)
    prepared = prepare(data.with_model(four_dof()), places_preset())
    assert prepared.left_out == ()
