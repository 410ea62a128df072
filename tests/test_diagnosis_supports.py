"""Supports that give: of what stands on one alone, and in some recordings only."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.causes import HarmonicForce, SupportSpring
from fe_models.causes.candidate import Candidate, HarmonicCandidate
from fe_models.lowpass import LowPass
from fe_models.structure import Beam
from hybrid.diagnosis.contest.growing import reference_fits_of
from hybrid.diagnosis.contest.recording_groups import Asked
from hybrid.diagnosis.contest.setting import Setting, setting_of
from hybrid.diagnosis.contest.switching import fit_switched
from hybrid.diagnosis.fitting.harmonic_amplitude import harmonic_amplitude
from hybrid.diagnosis.fitting.least_squares import fit
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.response.eigenmodes import eigenmodes
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from tests.masts import TUBE, masts, recorded

FOOT = {"node": 1, "direction": "rz"}
SPRING = SupportSpring(1, "rz", 5e6)  # N m/rad: takes a twentieth from the natural frequencies of a mast


def candidate_of(setting: Setting, kind: str, location: dict[str, object]) -> Candidate:
    """The candidate of a kind at a place."""
    return next(c for c in setting.candidates() if c.kind == kind and c.location == location)


@pytest.mark.slow
@pytest.mark.parametrize("stiffness", [1e6, 5e6])
def test_foot_of_a_mast_that_rocks_is_named(stiffness: float) -> None:
    given = recorded(masts().with_effects(SupportSpring(1, "rz", stiffness)))
    found = diagnose(replace(given, model=masts()))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("support_spring", FOOT)
    assert finding.probability > 0.9
    assert finding.parameters["stiffness"].value == pytest.approx(stiffness, rel=0.1)  # the contract's bound


@pytest.mark.slow
@pytest.mark.parametrize("since", [1, 2])
def test_foot_that_rocks_from_one_recording_on_is_named_with_these(since: int) -> None:
    """What all recordings ask for to first order leads to the storey above; what the last ones show does not."""
    before, after = recorded(masts()), recorded(masts().with_effects(SPRING))
    found = diagnose(replace(before, recordings=(*before.recordings[:since], *after.recordings[since:])))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("support_spring", FOOT)
    assert finding.recordings == tuple(recording.name for recording in before.recordings[since:])
    assert finding.probability > 0.9
    assert finding.parameters["stiffness"].value == pytest.approx(SPRING.stiffness, rel=0.1)  # the contract's bound


@pytest.mark.slow
def test_support_that_gives_in_some_recordings_is_fitted_there() -> None:
    before, after = recorded(masts()), recorded(masts().with_effects(SPRING))
    parts = (*before.recordings[:2], *after.recordings[2:])
    setting = setting_of(replace(before, recordings=parts))
    ground = reference_fits_of(
        setting.nominal_hypothesis, setting.nominal_hypothesis.centre, setting.lengths, setting.searched, setting.short
    )
    assert ground is not None
    asked = Asked(
        candidate_of(setting, "support_spring", FOOT), np.array([0.0, 0.0, 1.0]), np.full(3, 1e6), np.arange(3)
    )
    found = fit_switched(ground.short, ground.whole, (asked,), setting.lengths, setting.searched)
    names = [tuple(name for batch in item.batches if not batch.off for name in batch.names) for item in found]
    assert ("r2",) in names
    assert min(item.cost for item in found) < 0.5 * ground.whole.cost


def test_harmonic_force_is_named_beside_a_support_that_gives_in_some_recordings() -> None:
    force = HarmonicForce(2, "x", 20.0, 3.0)
    setting = setting_of(recorded(masts(), force))
    support, shaken = (
        candidate_of(setting, kind, place)
        for kind, place in (("support_spring", FOOT), ("harmonic_force", {"node": 2, "direction": "x"}))
    )
    hypothesis = setting.nominal_hypothesis.adding(support).adding(shaken)
    (batch,) = setting.lengths.whole
    batches = (replace(batch.take([0, 1]), off=(0,)), batch.take([2]))
    theta = np.array([*setting.nominal_hypothesis.centre, *support.lower, force.frequency])
    item = fit(hypothesis, theta, batches, setting.noise_model)
    assert item is not None
    assert harmonic_amplitude(item, 1).amplitude == pytest.approx(force.amplitude, rel=0.1)  # the contract's bound


def test_entries_of_a_mode_that_a_support_brings_count_up_to_a_low_pass() -> None:
    """Beyond it they take up no noise, as none is left; those of a machine always do."""
    given = recorded(masts().with_effects(SPRING))
    setting = setting_of(replace(given, model=masts()))
    foot = candidate_of(setting, "support_spring", FOOT)
    machine = next(c for c in setting.candidates() if isinstance(c, HarmonicCandidate))
    modes = setting.nominal.modes[0] / (2 * np.pi)
    for lowpass, counted in ((None, 2), (LowPass(1e6), 2), (LowPass(0.8 * modes[-1]), 0)):
        nominal = replace(setting.nominal, lowpass=lowpass)
        for candidates, more in (((foot,), counted), ((machine,), 2), ((foot, machine), 2 + counted)):
            hypothesis = Hypothesis(nominal, candidates)
            theta = hypothesis.centre.copy()
            theta[hypothesis.slices[0]] = 1 / SPRING.stiffness if candidates[0] is foot else 3.0
            states = (np.zeros((5, hypothesis.states)),)
            assert hypothesis.extra_entries(theta, states) == 5 * more
            rows = np.concatenate(hypothesis.own_motions(theta))
            assert rows.shape == (2 * len(candidates), hypothesis.states)


def test_what_a_support_brings_is_the_highest_mode_whatever_the_coordinates_hold() -> None:
    """A motion in the other modes has nothing of it, in one of them each coordinate."""
    tied = masts(apart=3.0)
    tied = replace(tied, elements=(*tied.elements, Beam((3, 6), TUBE)))
    setting = setting_of(recorded(tied))
    hypothesis = setting.nominal_hypothesis.adding(candidate_of(setting, "support_spring", FOOT))
    theta = np.append(setting.nominal_hypothesis.centre, 1 / 2e5)
    reduced = hypothesis.reduced(theta[None])
    shapes = eigenmodes(reduced.mass, reduced.stiffness).shapes[0]
    n = hypothesis.size
    displaced, moved = (part[0] for part in hypothesis.own_motions(theta))
    np.testing.assert_allclose(displaced[:n] @ shapes, np.eye(n)[-1], atol=1e-9)
    np.testing.assert_allclose(moved[n : 2 * n] @ shapes, np.eye(n)[-1], atol=1e-9)
    assert np.abs(shapes[-1, :-1]).max() > 0.01  # the last coordinate is in other modes, too
