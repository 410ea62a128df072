"""Modes above half the sampling rate, which recordings show at other frequencies if no filter has kept them out."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.assembly import linearise
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.diagnosis.contest.growing import reference_fits_of
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.outcome.folding import folding_of
from hybrid.diagnosis.outcome.rest import rest_of
from hybrid.diagnosis.recorded.spectra import strongest_apart
from tests.frames import portal
from tests.masts import SENSORS

RATE = 40.0  # Hz: the portal's fourth mode, of 62.3 Hz, shows at 40 - (62.3 - 40) = 17.7 Hz, the fifth, of 77.5, at 2.5
NOISE = 0.03


def sampled(modes: int) -> Dataset:
    """Recordings of the portal as drawn, its first ``modes`` all of the same acceleration, without any filter."""
    model, rng = portal(), np.random.default_rng(4)
    modal = natural_modes(linearise(model), modes)
    shapes = modal.shapes[modal.dofs.free].T
    begun = 0.3 * rng.standard_normal((2, 4, modes)) / modal.omega * modal.omega[0]
    start = (begun[0] / modal.omega) @ shapes, begun[1] @ shapes
    motion = simulate_free(model, *start, FreeConfig(6.0, RATE, 1e-4), progress=False)
    clean = np.stack([motion.shown(s) for s in SENSORS], axis=-1)
    data = clean + NOISE * clean.std(axis=(0, 1)) * rng.standard_normal(clean.shape)
    parts = tuple(Recording(f"r{i}", part[None], "test" if i == 3 else "train") for i, part in enumerate(data))
    return Dataset(model, RATE, SENSORS, parts)


def folding_notes(dataset: Dataset) -> list[str]:
    setting = setting_of(dataset)
    ground = reference_fits_of(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths, setting.noise_model
    )
    assert ground is not None
    natural = setting.nominal.modes[0] / (2 * np.pi)
    return [
        *folding_of(ground.whole, setting, setting.noise_model),
        rest_of(ground.whole, natural, setting.noise_model),
    ]


@pytest.mark.slow
def test_mode_that_folds_is_reported_by_both_its_frequencies() -> None:
    given = sampled(modes=4)
    note, rest = folding_notes(given)
    line = float(note.split("near ")[1].split()[0])
    assert abs(line - 17.7) < 4 / 6 + 0.02 * 62.3  # four lines of six seconds, and what the mesh leaves open
    assert "a mode of 62.31 Hz" in note
    assert f"near {line:.4g} Hz (no natural frequency)" in rest


@pytest.mark.slow
def test_nothing_folds_where_no_mode_is_so_fast_or_a_filter_is_stated() -> None:
    assert len(folding_notes(sampled(modes=3))) == 1  # the rest
    assert len(folding_notes(replace(sampled(modes=4), lowpass=19.0))) == 1


def test_strongest_line_is_distinguished_from_known_frequencies() -> None:
    time = np.arange(400) / RATE
    noise = np.random.default_rng(0).standard_normal((2, 400, 3))
    wave = np.exp(-2 * time)[:, None] * np.sin(2 * np.pi * 7.0 * time)[:, None]  # dies within a tenth of the recording
    known, width = np.array([0.0, 3.0]), np.full(2, 0.5)
    assert strongest_apart(known, width, (noise,), RATE) is None
    found = strongest_apart(known, width, (noise + 20 * wave,), RATE)
    assert found is not None
    assert abs(found - 7.0) < 0.2
    assert strongest_apart(np.array([0.0, 7.0]), np.array([0.5, 2.0]), (noise + 4 * wave,), RATE) is None
