"""Natural frequencies that are off in proportion to their square, against Newmark's method in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.judging import judge
from benchmarks.blind_cases import BlindConfig, blind_case
from benchmarks.blind_cases.bridge import SENSORS
from benchmarks.blind_cases.bridge_scene import free_motion
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.causes import AddedMass, TimeIntegration
from fe_models.files.bridge_recordings import LOWPASS
from fe_models.measurement import lowpassed
from fe_models.modes import natural_modes
from fe_models.recordings import Assumptions, Dataset, Recording
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.response.dispersion import dispersed, shift, step_of
from hybrid.diagnosis.response.eigenmodes import eigenmodes
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose

RATE = 100.0  # Hz
STEP = 1e-3  # s: a tenth of the sampling interval
EDGE = 100  # samples before and after, which the low-pass spoils


def simulated(step: float) -> Dataset:
    """Recordings of the bridge as Newmark's method shows it in steps of ``step`` s, behind a low-pass, noise of 2 %."""
    design, rng = bridge().without_prestress(), np.random.default_rng(3)
    modal = natural_modes(linearise(design), 10)
    omega, ratio = TimeIntegration(step).frequency_and_ratio(modal.omega, modal.damping_ratio)
    seen = replace(modal, omega=omega, damping_ratio=ratio)
    q = 1e-2 / seen.omega[:, None] * rng.standard_normal((10, 4))
    p = 1e-2 * rng.standard_normal((10, 4))
    motion = free_motion(seen, q, p, np.arange(-EDGE, 2000 + EDGE) / RATE)
    data = np.stack([motion.shown(s) for s in SENSORS], axis=-1)
    data = data + 0.02 * data.std(axis=(0, 1)) * rng.standard_normal(data.shape)
    data = np.stack([lowpassed(part, RATE, LOWPASS)[EDGE:-EDGE] for part in data])
    recordings = tuple(Recording(f"r{i}", part[None], "train" if i < 3 else "test") for i, part in enumerate(data))
    return Dataset(design, RATE, SENSORS, recordings, LOWPASS)


@pytest.fixture(scope="module")
def clean() -> Dataset:
    return simulated(STEP)


def test_frequencies_are_those_of_newmarks_method() -> None:
    """The next term of the period's error is (omega h)^4 / 80, here 1e-5 at the highest frequency, and so is its share
    of the bound: (omega h)^4 / 12.
    """
    omega = 2 * np.pi * np.array([1.6, 3.5, 6.4, 11.3, 20.0, 30.0])
    K = np.diag(omega**2)[None].repeat(2, axis=0)
    M = np.eye(6)[None].repeat(2, axis=0)
    found = eigenmodes(M, dispersed(M, K, np.array([1.0, 0.25]), RATE)).omega
    for own, step in zip(found, (STEP, STEP / 2), strict=True):
        expected = TimeIntegration(step).frequency_and_ratio(omega, np.zeros(6))[0]
        np.testing.assert_allclose(own / expected, 1.0, atol=1.2e-4)
        np.testing.assert_allclose((own / omega - 1)[:4], (expected / omega - 1)[:4], rtol=0.01)
        assert step_of((step / STEP) ** 2, RATE) == pytest.approx(step)
    assert shift(1.0, float(omega[-1]), RATE) == pytest.approx(found[0, -1] / omega[-1] - 1)


def test_modes_far_above_the_samples_stay_stable() -> None:
    K = np.diag([1e2, 1e8])[None].repeat(2, axis=0)
    M = np.eye(2)[None].repeat(2, axis=0)
    assert np.linalg.eigvalsh(dispersed(M, K, np.array([3.0, -3.0]), RATE)).min() > 0


@pytest.mark.slow
def test_a_simulation_in_steps_of_ones_own_has_none(clean: Dataset) -> None:
    """What its user's own steps do to it is a cause: see `TimeIntegration`."""
    own = replace(clean, assumptions=Assumptions(integrator="newmark", step=STEP))
    assert not nominal_model_of(own).disperses
    assert len(Hypothesis(nominal_model_of(clean)).centre) == len(Hypothesis(nominal_model_of(own)).centre) + 1


@pytest.mark.slow
def test_recordings_simulated_in_steps_show_nothing_wrong(clean: Dataset) -> None:
    found = diagnose(clean)
    assert found.verdict is Verdict.NOTHING_WRONG
    assert reported_step(found) == pytest.approx(STEP, rel=0.05)
    _, note = found.notes  # the other is on the ends of filtered recordings
    assert note.startswith("natural frequencies are lower")
    assert f"steps of {reported_step(found):.2g} s" in note


@pytest.mark.slow
def test_a_mass_is_found_in_a_bridge_simulated_in_steps() -> None:
    case = blind_case(1000001, BlindConfig((AddedMass.kind,), structure="bridge", step=STEP))
    found = diagnose(case.dataset)
    marks = judge(case, found)
    assert marks.named == marks.truth
    assert all(marks.within)
    assert found.findings[0].probability > 0.9


def reported_step(found: Diagnosis) -> float:
    best = found.posterior.fits[0]
    return step_of(float(best.theta[best.hypothesis.nominal.dispersion]), RATE)
