"""Recordings in two groups: what chance makes of them, and what those say that hardly feel a cause."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from benchmarks.blind_cases import SENSORS
from fe_models.built_in.four_dof import four_dof
from fe_models.causes.candidate import Candidate
from fe_models.causes.places import Motion
from fe_models.recordings import Dataset, Recording
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.diagnosis.contest.config import GROUPS
from hybrid.diagnosis.contest.odds import log_of_groups
from hybrid.diagnosis.contest.recording_groups import Asked, asked_for, clear_share, each_of_two
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.batches import Batch, as_made, batches_of, columns_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis

DRAWS = 20_000
NOISE = 0.01
MEASURED = (0, 1, 2, 3)


@pytest.mark.parametrize("recordings", [2, 3, 4, 5, 9, 12])
def test_chance_hardly_makes_two_clear_groups(recordings: int) -> None:
    drawn = np.sort(np.random.default_rng(recordings).standard_normal((DRAWS, recordings)), axis=1)
    within = [drawn[:, :k].var(axis=1) * k + drawn[:, k:].var(axis=1) * (recordings - k) for k in range(1, recordings)]
    share = np.min(within, axis=0) / (drawn.var(axis=1) * recordings)
    assert np.mean(share < clear_share(recordings)) < 0.01  # as its docstring says


@pytest.mark.parametrize("apart", [False, True])  # in batches of their own, as of two lengths
def test_two_recordings_are_a_group_each_but_not_halves_of_one(apart: bool) -> None:
    data = np.arange(12.0).reshape(2, 3, 2)
    both = Batch(data, ("before", "after"), order=(0, 1), skipped=(0, 0))
    found = each_of_two((both.take([0]), both.take([1])) if apart else (both,))
    assert found is not None
    for (group,), name, own in zip(found, both.names, data, strict=True):
        assert group.names == (name,)
        np.testing.assert_array_equal(group.data, own[None])
    assert each_of_two((replace(both, names=("one", "one")),)) is not None  # two motions of one file
    assert each_of_two((replace(both, names=("one", "one"), skipped=(0, 3)),)) is None
    assert each_of_two((both.take([0]),)) is None
    assert each_of_two((both, both)) is None


def gap_stop() -> tuple[Dataset, Candidate]:
    """Return five motions of the chain, two of them large, and a stop that only these touch, in one direction."""
    rng = np.random.default_rng(2)
    state = rng.standard_normal((2, 5, 4)) * np.array([0.1, 1.0, 0.1, 1.0, 0.1])[:, None]
    motion = simulate_free(
        four_dof(), state[0], state[1], FreeConfig(duration=20.0, sampling_rate=10.0), progress=False
    )
    data = np.stack([motion.shown(s) for s in SENSORS], axis=-1)
    data = data + NOISE * rng.standard_normal(data.shape)
    dataset = Dataset(four_dof(), 10.0, SENSORS, tuple(Recording(f"r{i}", part[None]) for i, part in enumerate(data)))
    nominal = nominal_model_of(dataset)
    moved = Motion(*(motion.displacement.reshape(-1, 4), motion.velocity.reshape(-1, 4)))
    stops = all_candidates(nominal, dataset, moved, MEASURED)
    return dataset, next(c for c in stops if c.kind == "gap_stop" and c.location.get("node") == 2)


def test_a_stop_that_most_recordings_do_not_touch_tells_no_groups() -> None:
    dataset, stop = gap_stop()
    batches = columns_of(batches_of(dataset, "train"), MEASURED)
    noise_model = NoiseModel(SENSORS[:4], 10.0, np.full(4, NOISE))
    nominal = Hypothesis(nominal_model_of(dataset))
    base = fit(nominal, nominal.centre, batches, noise_model)
    assert base is not None
    assert asked_for(base, (stop,), noise_model) == ()


def test_groups_are_split_for_the_least_variance() -> None:
    _, any_candidate = gap_stop()
    asked = Asked(any_candidate, np.array([1.0, 5.0, np.nan, 1.2, 5.1]), np.ones(5), np.arange(5))
    assert not asked.is_change
    assert list(asked.high) == [False, True, False, False, True]  # what hardly feels it is not in the upper
    ranked = np.array([1.0, 1.2, 5.0, 5.1])
    left = 2 * np.var(ranked[:2]) + 2 * np.var(ranked[2:])
    assert asked.within == pytest.approx(left / (4 * np.var(ranked)))


def test_chance_makes_a_change_as_often_as_it_says() -> None:
    _, any_candidate = gap_stop()
    drawn = np.random.default_rng(4).standard_normal((400, 9))
    changes = [Asked(any_candidate, amounts, np.ones(9), np.arange(9)).is_change for amounts in drawn]
    assert np.mean(changes) == pytest.approx(GROUPS.max_chance, abs=0.05)  # three standard deviations of 400 draws


def test_a_change_is_detected_by_what_feels_it() -> None:
    _, any_candidate = gap_stop()
    amounts = np.array([0.0, 0.9, 0.1, -0.1, 1.0, 0.9, 1.1, 0.2])  # the second and the last hardly feel it
    sizes = np.array([9.0, 0.1, 9.0, 9.0, 9.0, 9.0, 9.0, 0.1])
    asked = Asked(any_candidate, amounts, sizes, np.arange(8))
    assert asked.is_change
    assert list(asked.high) == [False] * 4 + [True] * 4
    assert not Asked(any_candidate, amounts, np.ones(8), np.arange(8)).is_change


def test_recordings_of_unequal_length_are_grouped_in_the_order_they_were_made() -> None:
    """Those of one length stand together: r0, r2, ... before r1, r3, ...; a change came after the fourth of eight."""
    lengths = (100, 90) * 4
    given = Dataset(
        four_dof(), 10.0, SENSORS, tuple(Recording(f"r{i}", np.ones((1, n, 5))) for i, n in enumerate(lengths))
    )
    batches = batches_of(given, "train")
    names = [name for batch in batches for name in batch.names]
    made = as_made(batches)
    assert [names[i] for i in made] == [f"r{i}" for i in range(8)]
    amounts = np.array([float(int(name[1:]) >= 4) for name in names])
    asked = Asked(gap_stop()[1], amounts, np.ones(8), made)
    assert asked.is_change
    assert [name for name, high in zip(names, asked.high, strict=True) if high] == ["r4", "r6", "r5", "r7"]


def test_groups_of_recordings_are_as_probable_as_they_are_many() -> None:
    """All 2^n of them together no more probable than two of one; what comes once more so than what comes and goes."""
    for count in (2, 3, 6, 9):
        groups = list(product((False, True), repeat=count))[1:-1]
        logs = np.array([log_of_groups(np.array(group)) for group in groups])
        once = np.array([np.count_nonzero(np.diff(group)) == 1 for group in groups])
        assert np.exp(logs[once]).sum() == pytest.approx(0.5)
        assert np.exp(logs[~once]).sum() <= 0.5
        assert np.ptp(logs[once]) == 0
        assert count < 6 or logs[once].min() > logs[~once].max()
    assert log_of_groups(np.ones(5, dtype=bool)) == 0.0
