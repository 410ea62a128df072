"""The time step of a simulation follows from the highest natural frequency in the recordings' band."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.modes import natural_modes
from fe_models.simulation import ReleaseConfig, simulate_release
from fe_models.statics import PointLoad
from fe_models.structure import Damping
from fe_models.synthetic import Acquisition
from fe_models.time_step import LONGEST_STEP, MAX_FREQUENCY_ERROR, TimeStep, highest_frequency, time_step
from tests.problems import cantilever


@pytest.mark.parametrize("band", [1.0, 5.0, 30.0, 200.0])
def test_the_highest_frequency_lies_in_the_band_and_the_next_does_not(band: float) -> None:
    """More modes than are solved for at first; below the first one there is none, and that one counts."""
    every = natural_modes(linearise(bridge()), 100).frequencies
    found = highest_frequency(bridge(), band)
    expected = every[every <= band][-1] if band > every[0] else every[0]
    assert found == pytest.approx(expected, rel=1e-6)


def test_the_step_keeps_that_frequency_right() -> None:
    chosen = time_step(bridge(), 30.0)
    assert chosen.frequency_error == pytest.approx(MAX_FREQUENCY_ERROR, rel=1e-3)  # the series' next term: (w h)^2 / 8
    assert time_step(bridge(), 2.0).step == LONGEST_STEP
    assert time_step(bridge(), 30.0, 1e-3).step == 1e-3


def test_the_error_stated_is_that_of_a_simulation() -> None:
    """A beam's first mode alone, released without gravity: zero crossings, interpolated, over many periods."""
    structure = replace(cantilever(), damping=Damping(modal_ratios=(0.001, 0.5)))  # nothing but the first mode lasts
    frequency = float(natural_modes(linearise(structure), 1).frequencies[0])
    step = 0.05 / frequency
    config = ReleaseConfig(60 / frequency, 1 / step, step, gravity=0.0)
    motion = simulate_release(structure, (PointLoad(2, "y", 1e-3),), config, progress=False)
    y = motion.channel(2, "y", "displacement")[200:]
    before = np.flatnonzero((y[:-1] < 0) & (y[1:] >= 0))
    crossings = motion.time[200:][before] + step * y[before] / (y[before] - y[before + 1])
    measured = (len(crossings) - 1) / (crossings[-1] - crossings[0])
    predicted = TimeStep(step, frequency).frequency_error
    assert predicted > 5e-3
    assert 1 - measured / frequency == pytest.approx(predicted, rel=0.05)  # a tenth of a period over 40 would be 25 %


def test_the_band_ends_at_the_low_pass_or_at_half_the_sampling_rate() -> None:
    assert Acquisition(100.0, None).band == 50.0
    assert 30.0 < Acquisition(100.0, 30.0).band < 45.0
    assert Acquisition(100.0, 49.0).band == 50.0
