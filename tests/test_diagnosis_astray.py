"""Calibrations that go far: after a machine, which leaves the mode itself, and after a cable that is mostly slack."""

import numpy as np
import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.causes import HarmonicForce, SlackCable
from fe_models.causes.candidate import HarmonicCandidate
from fe_models.progress import nothing
from hybrid.diagnosis.contest.growing import reference_fits_of
from hybrid.diagnosis.contest.harmonic import fit_forces
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.contest.starts import best_start
from hybrid.diagnosis.fitting.calibration_deviation import deviation_of
from hybrid.diagnosis.fitting.config import CALIBRATION
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.screening.screening import screen


@pytest.mark.slow
def test_a_machine_that_the_calibration_followed_is_found_from_the_structure_as_drawn() -> None:
    """A machine 2 % below the fourth mode, which moves more than the mode does."""
    config = BlindConfig(("harmonic_force",), structure="bridge", tier="off", train=3, test=1, rich=False)
    case = blind_case(720031, config)
    (truth,) = case.truth
    assert isinstance(truth, HarmonicForce)
    assert truth.node == 38
    setting = setting_of(case.dataset)
    noise_model = setting.searched
    ground = reference_fits_of(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths, noise_model, setting.short
    )
    assert ground is not None
    base = ground.whole
    assert deviation_of(base) > 10 * CALIBRATION.max_deviation_sigma
    system = system_of(base.hypothesis, base.theta[None], noise_model.outputs)
    natural = np.linalg.eigvals(system.A[0]).imag / (2 * np.pi)  # Hz
    assert np.abs(natural - truth.frequency).min() < 0.001  # nothing is left there that a force could explain
    forces = tuple(c for c in setting.candidates() if isinstance(c, HarmonicCandidate))
    found = min(fit_forces(base, forces, [], noise_model, nothing), key=lambda item: item.cost)
    assert found.theta[-1] == pytest.approx(truth.frequency, abs=0.001)  # a fiftieth of what 20 s resolve
    assert found.hypothesis.candidates[0].location == {"node": 38, "direction": "x"}


@pytest.mark.slow
def test_a_cable_that_is_mostly_slack_begins_so_in_the_structure_as_drawn() -> None:
    """The calibration has softened it and much else; from there, or hardly slack, no step leads down."""
    case = blind_case(950009, BlindConfig(("slack_cable",), structure="bridge", tier="off", rich=False))
    (truth,) = case.truth
    assert isinstance(truth, SlackCable)
    setting = setting_of(case.dataset)
    noise_model = setting.searched
    ground = reference_fits_of(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths, noise_model, setting.short
    )
    assert ground is not None
    cables = tuple(c for c in setting.candidates() if c.kind == truth.kind and c.location == truth.location)
    (trial,) = screen(ground.whole, cables, noise_model)
    begun = best_start(ground.hypothesis, ground.short, noise_model, trial)
    assert begun is not None
    assert begun.cost < 0.02 * ground.short.cost
    assert begun.theta[-1] == pytest.approx(truth.pretension, rel=0.02)
