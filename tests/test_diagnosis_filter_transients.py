"""Ends of low-passed recordings: how long a filter that begins amid a motion rings, and what that is taken for."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import SENSORS as CHAIN_SENSORS
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import StiffnessChange
from fe_models.measurement import lowpassed
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Load, Recording
from fe_models.simulation import FreeConfig, simulate_free
from fe_models.structure import Structure
from hybrid.diagnosis.nominal.unstated_lowpass import unstated_lowpass
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.filter_transients import without_ringing_ends
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from tests.masts import SENSORS, masts

RATE, LOWPASS, FINE = 100.0, 30.0, 1000.0
ENDS = 7  # samples of two periods of the low-pass
NOISE = 0.03  # of each channel's rms


def released(structure: Structure, duration: float = 6.0) -> Dataset:
    """Masts pulled at four places, let go when recordings begin; filtered with the rest before and sampled."""
    rng = np.random.default_rng(5)
    linear = linearise(structure)
    stiffness, free = linear.stiffness.toarray(), linear.dofs
    recordings = []
    for number, (first, second) in enumerate(((3000.0, 0.0), (-2000.0, 4000.0), (1500.0, 3000.0), (2500.0, -2500.0))):
        pull = np.zeros(len(free))
        pull[[free.row(3, "x"), free.row(2, "x"), free.row(6, "x"), free.row(5, "x")]] = first, second, second, first
        start = np.linalg.solve(stiffness, pull[free.free])[None]
        motion = simulate_free(structure, start, 0 * start, FreeConfig(duration, FINE, 2e-4), progress=False)
        clean = np.stack([motion.shown(s)[0] for s in SENSORS], axis=-1)
        before = np.zeros((500, len(SENSORS)))
        shown = lowpassed(np.concatenate([before, clean]), FINE, LOWPASS)[len(before) :: round(FINE / RATE)]
        noise = lowpassed(rng.standard_normal(shown.shape), RATE, LOWPASS)
        data = shown + NOISE * shown.std(axis=0) / noise.std(axis=0) * noise
        recordings.append(Recording(f"r{number}", data[None], "test" if number == 3 else "train"))
    return Dataset(masts(apart=3.0), RATE, SENSORS, tuple(recordings), LOWPASS)


def test_what_rings_is_left_out_with_the_loads_there() -> None:
    load = Load(3, "x", np.arange(300.0))
    given = Dataset(masts(), RATE, SENSORS, (Recording("r", np.ones((1, 300, 4)), loads=(load,)),), LOWPASS)
    cut, (note,) = without_ringing_ends(given)
    assert cut.recordings[0].data.shape == (1, 300 - 2 * ENDS, 4)
    np.testing.assert_array_equal(cut.recordings[0].loads[0].values, np.arange(ENDS, 300.0 - ENDS))
    assert f"{ENDS} samples at each end" in note


@pytest.mark.parametrize(
    ("lowpass", "samples", "kept"), [(None, 300, 300), (LOWPASS, 33, 33), (LOWPASS, 35, 33), (LOWPASS, 100, 90)]
)
def test_nothing_is_left_out_without_a_low_pass_and_little_of_short_recordings(
    lowpass: float | None, samples: int, kept: int
) -> None:
    recordings = (Recording("r", np.ones((1, samples, 4))),)
    cut, _ = without_ringing_ends(Dataset(masts(), RATE, SENSORS, recordings, lowpass))
    assert cut.recordings[0].data.shape[1] == kept


def test_a_load_that_has_not_passed_the_low_pass_does_so_whole() -> None:
    white = np.random.default_rng(1).standard_normal((300, 1))
    recording = Recording("r", np.ones((1, 300, 4)), loads=(Load(3, "x", white[:, 0]),))
    cut, _ = without_ringing_ends(Dataset(masts(), RATE, SENSORS, (recording,), LOWPASS))
    passed = lowpassed(white, RATE, LOWPASS)[ENDS:-ENDS, 0]
    np.testing.assert_allclose(cut.recordings[0].loads[0].values, passed, atol=1e-12)


@pytest.mark.slow
def test_drift_counts_from_where_a_recording_began() -> None:
    """What is not used of it had drifted already: 0.1094 +- 0.0003 was estimated."""
    rng, slope, sensors = np.random.default_rng(1), 0.1, tuple(s for s in CHAIN_SENSORS if s.role == "measured")
    begun = rng.standard_normal((2, 5, 4))
    motion = simulate_free(four_dof(), begun[0], begun[1], FreeConfig(30.0, 100.0, 0.005), progress=False)
    clean = np.stack([motion.shown(s) for s in sensors], axis=-1)
    recordings = []
    for number, part in enumerate(clean):
        shown = lowpassed(part, 100.0, 1.0)[::10]
        shown = shown + 0.1 * lowpassed(rng.standard_normal(shown.shape), 10.0, 1.0)
        shown[:, 1] += slope * np.arange(len(shown)) / 10.0
        recordings.append(Recording(f"r{number}", shown[None], "test" if number == 4 else "train"))
    found = diagnose(Dataset(four_dof(), 10.0, sensors, tuple(recordings), 1.0))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("sensor_drift", {"sensor": sensors[1].name})
    assert abs(finding.parameters["slope"].value - slope) < 3 * finding.parameters["slope"].std
    assert finding.parameters["slope"].std < 0.01 * slope


def test_ringing_of_a_release_is_over_where_recordings_are_used() -> None:
    """Held against the response of a filter that saw the motion go on for ever before: that of complex exponentials."""
    omega = 2 * np.pi * 4.0
    time = np.arange(-2.0, 3.0, 1 / FINE)
    wave = np.cos(omega * time)
    every, begin = round(FINE / RATE), round(2.0 * FINE)
    begun = lowpassed(np.where(time < 0, 0.0, wave)[:, None], FINE, LOWPASS)[begin::every, 0]
    ever = lowpassed(wave[:, None], FINE, LOWPASS)[begin::every, 0]
    off = np.abs(begun - ever)
    assert off[0] > 0.4  # half the jump
    assert off[ENDS:100].max() < 0.01


@pytest.mark.slow
def test_a_release_at_the_first_sample_is_no_damper() -> None:
    """It was reported as a negative or huge damper beside the softer element, or as an axial force beyond yielding."""
    found = diagnose(released(masts(apart=3.0).with_effects(StiffnessChange((2,), 0.75))))
    assert found.verdict is Verdict.EXPLAINED
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("stiffness_change", {"element": 2})
    assert finding.parameters["factor"].value == pytest.approx(0.75, rel=0.1)  # the contract's bound


def test_a_low_pass_that_is_not_stated_is_detected_and_no_other() -> None:
    given = released(masts(apart=3.0), duration=3.0)
    assert unstated_lowpass(given) == []
    (none,), (other,) = (unstated_lowpass(replace(given, lowpass=lowpass)) for lowpass in (None, 45.0))
    assert "which the dataset does not state" in none
    assert "not 45 Hz as stated" in other
    estimated = float(none.split("lowpass = ")[1])
    assert estimated == pytest.approx(LOWPASS, rel=0.1)


@pytest.mark.parametrize("noise", [0.0, 1e-3, 0.1])
def test_recordings_without_low_pass_end_nowhere(noise: float) -> None:
    structure = masts(apart=3.0)
    modal = natural_modes(linearise(structure), 2)
    start = 0.01 * modal.shapes[modal.dofs.free].T
    motion = simulate_free(structure, start, 0 * start, FreeConfig(5.0, RATE, 2e-4), progress=False)
    data = np.stack([motion.channel(s.node, str(s.direction), "displacement") for s in SENSORS], axis=-1)
    data = data + noise * data.std() * np.random.default_rng(1).standard_normal(data.shape)
    assert unstated_lowpass(Dataset(structure, RATE, SENSORS, (Recording("r", data),))) == []
