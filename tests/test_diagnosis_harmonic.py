"""Harmonic forces, whatever the unit of time, the user's time steps, and what else runs slowly."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.assembly import linearise
from fe_models.causes import HarmonicForce
from fe_models.causes.candidate import HarmonicCandidate
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset
from hybrid.diagnosis.contest.growing import reference_fits_of
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.screening.force_screening import _harmonic_gains, screen_forces
from tests.chain_fits import RATE, candidate, gauge_of
from tests.masts import DURATION, masts, recorded

FORCED = blind_case(7, BlindConfig(("harmonic_force",), size=0.6, train=3, test=1, duration=30.0))


def machine() -> HarmonicForce:
    (cause,) = FORCED.truth
    assert isinstance(cause, HarmonicForce)
    return cause


def fitted(dataset: Dataset, begun: float) -> Fit:
    """Return the fit of a harmonic force where it acts, from a frequency that is ``begun`` (Hz)."""
    batches, noise_model = gauge_of(dataset)
    hypothesis = Hypothesis(nominal_model_of(dataset), (candidate(dataset, "harmonic_force", node=machine().node),))
    found = fit(hypothesis, np.append(np.zeros(hypothesis.nuisances), begun), batches, noise_model)
    assert found is not None
    return found


def test_its_frequency_costs_nothing_in_any_unit_of_time() -> None:
    """Its prior was as wide as 1 Hz: of a stiff structure's machine it took (108 Hz)^2 off."""
    force = candidate(FORCED.dataset, "harmonic_force", node=machine().node)
    assert force.width == (RATE / 2,)  # without a low-pass
    hypothesis = Hypothesis(nominal_model_of(FORCED.dataset), (force,))
    assert hypothesis.precision[-1] * (RATE / 2) ** 2 <= 1  # at the highest that recordings show


def test_it_keeps_its_frequency_in_a_simulation_by_time_steps() -> None:
    """Natural frequencies are lower there; a force's is what the user makes it."""
    own = replace(FORCED.dataset.assumptions, integrator="newmark", step=0.08)
    force = candidate(FORCED.dataset, "harmonic_force", node=machine().node)
    exact, stepped = (
        Hypothesis(nominal_model_of(replace(FORCED.dataset, assumptions=assumptions)), (force,))
        for assumptions in (FORCED.dataset.assumptions, own)
    )
    roots = []
    for hypothesis in (exact, stepped):
        theta = np.append(np.zeros(hypothesis.nuisances), 0.9)  # 0.9 Hz, which steps of 0.08 s would show as 0.885
        sensors = FORCED.dataset.sensors
        system = system_of(hypothesis, theta[None], SensorOutputs.measured(sensors, RATE))
        roots.append(np.linalg.eigvals(system.A[0]))
    force_root = 2j * np.pi * 0.9
    assert [np.abs(own - force_root).min() for own in roots] == pytest.approx([0, 0], abs=1e-9)
    own_roots = [np.sort(found.imag)[-2] for found in roots]  # the structure's highest
    assert own_roots[1] < 0.999 * own_roots[0]


def test_another_one_is_screened_for_beside_one_at_a_frequency_that_is_tried() -> None:
    """The lowest that is tried is the least that a fit may have: an undamped root, where the system is singular."""
    batches, noise_model = gauge_of(FORCED.dataset)
    longest = max(batch.samples for batch in batches)
    item = fitted(FORCED.dataset, RATE / longest)
    slow = replace(item, theta=np.append(item.theta[:-1], RATE / longest))
    forces = (candidate(FORCED.dataset, "harmonic_force", node=machine().node),)
    found = screen_forces(slow, forces, noise_model)
    assert found
    assert all(np.isfinite(trial.gain) for trial in found)


@pytest.mark.slow
@pytest.mark.parametrize(("amplitude", "is_found"), [(20.0, True), (5.0, False)])
def test_it_is_found_at_a_difference_of_natural_frequencies_only_where_it_is_much(
    amplitude: float, is_found: bool
) -> None:
    """A little of a frame's motion is there as it is, when its geometry shows; not as much as most of what is left."""
    first, _, third, _ = natural_modes(linearise(masts()), 4).frequencies
    setting = setting_of(recorded(masts(), HarmonicForce(3, "x", amplitude, third - first, 0.3)))
    ground = reference_fits_of(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths, setting.noise_model
    )
    assert ground is not None
    best = screen_forces(ground.whole, setting.candidates(), setting.noise_model)[0]
    assert (best.start[0] == pytest.approx(third - first, abs=1 / DURATION / 2)) == is_found
    if is_found:
        assert best.candidate.location == {"node": 3, "direction": "x"}
        assert best.gain > 0.9 * ground.whole.misfit


def test_a_machine_that_was_found_is_none_of_the_modes_whose_multiples_a_frame_makes_by_itself() -> None:
    first, second = HarmonicForce(3, "x", 1500.0, 7.4, 0.3), HarmonicForce(6, "x", 6.0, 14.8, 0.3)
    setting = setting_of(recorded(masts(), first, second))
    forces = {
        c.location["node"]: c
        for c in setting.candidates()
        if isinstance(c, HarmonicCandidate) and c.location["direction"] == "x"
    }
    hypothesis = setting.nominal_hypothesis.adding(forces[3])
    found = reference_fits_of(
        hypothesis, np.append(np.zeros(hypothesis.nuisances), 7.4), setting.lengths, setting.noise_model
    )
    assert found is not None
    best = screen_forces(found.whole, (forces[6],), setting.noise_model)[0]
    assert best.start[0] == pytest.approx(14.8, abs=1 / DURATION / 2)
    assert best.gain > 0.5 * found.whole.misfit


def test_gains_are_those_of_least_squares() -> None:
    """A force at each frequency, free in amplitude and phase, beside a basis that was projected out."""
    rng, samples, sensors, count = np.random.default_rng(3), 30, 2, 80
    basis = np.linalg.qr(rng.standard_normal((samples * sensors, 3)))[0]
    residual = rng.standard_normal((2, samples * sensors))
    residual -= residual @ basis @ basis.T
    lines = np.array([2, 7, 19])
    transfer = rng.standard_normal((3, sensors, 1)) + 1j * rng.standard_normal((3, sensors, 1))
    found = _harmonic_gains(residual, basis, transfer, lines, count)[:, 0]
    for line, shown, gain in zip(lines, transfer[..., 0], found, strict=True):
        turning = np.exp(2j * np.pi * line / count * np.arange(samples))
        course = (turning[:, None] * shown).ravel()
        columns = np.column_stack([course.real, course.imag])
        columns -= basis @ (basis.T @ columns)
        left = residual.T - columns @ np.linalg.lstsq(columns, residual.T, rcond=None)[0]
        assert gain == pytest.approx(np.sum(residual**2) - np.sum(left**2), rel=1e-6)  # a ridge of 1e-9
