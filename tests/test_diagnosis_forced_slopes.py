"""Linearisations under force laws: they foretell what a small move of parameters and initial states leaves."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import SENSORS
from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring
from fe_models.recordings import Dataset, Load, Recording
from hybrid.diagnosis.fitting.linearisation import linearise_batch
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.batches import Batch, batches_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis

RATE, SAMPLES = 10.0, 120
FITTED = tuple(sensor for sensor in SENSORS if sensor.role == "measured")
SMALL = 1e-4  # of a step
CURVED = 1e-3  # of what a small step changes: measured 2e-4, of second order in it


def case(loaded: bool) -> tuple[Hypothesis, FloatArray, Batch, NoiseModel, FloatArray]:
    """Return a chain with a cubic spring, recordings that are noise, and where they are linearised."""
    rng = np.random.default_rng(3)
    pushes = [(Load(2, "x", 0.5 * rng.standard_normal(SAMPLES)),) if loaded else () for _ in range(3)]
    data = rng.standard_normal((3, 1, SAMPLES, len(SENSORS)))
    recordings = tuple(Recording(f"r{i}", data[i], loads=loads) for i, loads in enumerate(pushes))
    structure = four_dof().with_effects(CubicSpring((1,), "x", 0.5))
    dataset = Dataset(structure, RATE, SENSORS, recordings)
    hypothesis = Hypothesis(nominal_model_of(dataset))
    (batch,) = batches_of(dataset, "train")
    noise_model = NoiseModel(FITTED, RATE, np.ones(len(FITTED)))
    batch = Batch(batch.data[..., : len(FITTED)], batch.names, loads=batch.loads)
    theta, states = 0.01 * rng.standard_normal(hypothesis.nuisances), rng.standard_normal((3, hypothesis.states))
    return hypothesis, theta, batch, noise_model, states


@pytest.mark.parametrize("loaded", [False, True])
def test_a_small_step_leaves_what_the_linearisation_says(loaded: bool) -> None:
    hypothesis, theta, batch, noise_model, states = case(loaded)
    part = linearise_batch(hypothesis, theta, batch, noise_model, states)
    assert part is not None

    def left(theta: FloatArray, states: FloatArray) -> FloatArray:
        moved = linearise_batch(hypothesis, theta, batch, noise_model, states, slopes=False)
        assert moved is not None
        return (part.raw - moved.raw).reshape(len(states), -1) / SMALL

    taken = left(theta, states + SMALL * part.state_step)  # what initial states can take of each recording
    expected = part.raw.reshape(len(states), -1) - part.residual
    assert np.abs(taken - expected).max() < CURVED * np.abs(expected).max()
    for number, width in enumerate(hypothesis.width):
        step = np.zeros_like(theta)
        step[number] = SMALL * width
        gone = left(theta + step, states + step[number] * part.state_slopes[number])
        slope = part.slopes[number] * width
        assert np.abs(gone - slope).max() <= CURVED * np.abs(slope).max()  # one factor does nothing here


def test_without_slopes_the_same_is_left() -> None:
    hypothesis, theta, batch, noise_model, states = case(loaded=False)
    linear = replace(hypothesis, nominal=replace(hypothesis.nominal, laws=()))
    uneven = replace(batch, noise=np.random.default_rng(4).uniform(0.5, 2.0, (3, len(FITTED))))
    for own, begin in ((hypothesis, states), (linear, None)):
        for brief in (False, True):
            with_slopes, without = (
                linearise_batch(own, theta, uneven, noise_model, begin, slopes=slopes, brief=brief)
                for slopes in (True, False)
            )
            assert with_slopes is not None
            assert without is not None
            np.testing.assert_allclose(without.raw, with_slopes.raw, atol=1e-9)  # rounding
