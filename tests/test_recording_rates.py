"""Each recording may have a sampling rate and an excitation of its own."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fe_models.built_in.four_dof import four_dof
from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset, save_dataset
from fe_models.four_dof_data import paper_sensors
from fe_models.recordings import Dataset, Load, Recording, Sensor
from fe_models.simulated_recordings import simulate
from hybrid.config import Config
from hybrid.diagnosis.modes_and_motion.modal_diagnosis import diagnose_modes
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose
from hybrid.identification.recording_comparison import compare_recordings
from hybrid.training.preparation import prepare
from tests.sample_dataset import TOML, assert_fault, faults_of, free_decay, write_sample

FIRST = 'key = "data"\n\n'  # the end of the first recording's table


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return write_sample(tmp_path)


def with_keys(folder: Path, first: str, *changes: tuple[str, str]) -> Dataset:
    """The sample dataset with more keys for its first recording."""
    text = TOML.replace(FIRST, f'key = "data"\n{first}\n\n', 1)
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    (folder / "dataset.toml").write_text(text)
    return load_dataset(folder / "dataset.toml")


def test_a_recording_s_own_rate_and_excitation_are_read_and_saved(folder: Path, tmp_path: Path) -> None:
    dataset = with_keys(folder, 'sampling_rate = 80.0\nexcitation = "ambient"')
    own, other = dataset.recordings
    assert (own.sampling_rate, own.excitation, dataset.rate_of(own)) == (80.0, "ambient", 80.0)
    assert (other.sampling_rate, other.excitation, dataset.rate_of(other)) == (None, None, 100.0)
    assert "each 4 to 5 s at 80 and 100 Hz" in repr(dataset)
    saved = load_dataset(save_dataset(dataset, tmp_path / "saved"))
    assert [(r.sampling_rate, r.excitation) for r in saved.recordings] == [(80.0, "ambient"), (None, None)]


def test_the_dataset_s_rate_may_be_left_out_where_each_recording_has_one(folder: Path) -> None:
    rate = ("sampling_rate = 100.0\n", "")
    second = 'role = "test"\n'
    dataset = with_keys(folder, "sampling_rate = 80.0", rate, (second, f"{second}sampling_rate = 80.0\n"))
    assert (dataset.sampling_rate, *(r.sampling_rate for r in dataset.recordings)) == (80.0, None, None)
    with pytest.raises(InputError, match="sampling_rate: missing"):
        with_keys(folder, "sampling_rate = 80.0", rate)


def test_an_own_rate_is_checked_like_the_dataset_s(folder: Path) -> None:
    with pytest.raises(InputError, match=r"\(r1\): lowpass = 30 Hz is not below half the sampling_rate, 20 Hz"):
        with_keys(folder, "sampling_rate = 40.0")
    with pytest.raises(InputError, match=r"\(r1\): sampling_rate = -1 Hz; must be positive"):
        with_keys(folder, "sampling_rate = -1.0")
    np.savez(folder / "r1.npz", data=free_decay(1), dt=0.01)
    with pytest.raises(InputError, match=r"its dt is 0\.01 s \(100 Hz\), but sampling_rate says 80 Hz"):
        with_keys(folder, "sampling_rate = 80.0")


@pytest.mark.parametrize("said", ["free", "ambient"])
def test_an_excitation_that_contradicts_the_loads_is_refused(folder: Path, said: str) -> None:
    faults = faults_of(folder, ('role = "test"\n', f'role = "test"\nexcitation = "{said}"\n'))
    assert_fault(faults, f'excitation = "{said}" contradicts its loads; leave it out, or say "measured"')
    faults = faults_of(folder, (FIRST, 'key = "data"\nexcitation = "measured"\n\n'))
    assert_fault(
        faults,
        'excitation = "measured", but nothing says what was: name it in [[recordings.loads]] or [[recordings.base]]',
    )
    faults = faults_of(folder, (FIRST, 'key = "data"\nexcitation = "wind"\n\n'))
    assert_fault(faults, 'excitation: expected "free" or "measured" or "ambient", found "wind"')


def two_rates(second: float = 20.0, duration: float = 50.0, sensors: Sequence[str | Sensor] | None = None) -> Dataset:
    """Free decays of the chain at 10 Hz, whose middle recording is said to be sampled at another rate."""
    places = sensors or paper_sensors()
    slow, fast = (
        simulate(four_dof(), places, duration=duration, sampling_rate=rate, noise=0.01, seed=1, motions=2)
        for rate in (10.0, second)
    )
    a, b = slow.recordings
    c, _ = fast.recordings
    own = replace(c, name="fast", sampling_rate=second)
    return replace(slow, recordings=(a, own, replace(b, role="test")))


def test_where_rates_differ_what_needs_one_says_so() -> None:
    dataset = two_rates()
    words = (
        r"different sampling rates \(motion_1, motion_2 at 10 Hz; fast at 20 Hz\), and .* needs one: state the lowpass"
    )
    for use in (diagnose, lambda data: prepare(data, Config())):
        with pytest.raises(InputError, match=words):
            use(dataset)


def test_below_a_stated_lowpass_faster_recordings_are_thinned() -> None:
    """Every second sample of a recording at 20 Hz, which goes with those at 10 Hz, with modes and windows alike."""
    given = replace(two_rates(), lowpass=4.0)
    thinned = given.of_one_rate("a test")
    assert thinned.sampling_rates == (10.0,)
    np.testing.assert_array_equal(thinned.recordings[1].data, given.recordings[1].data[:, ::2])
    found = compare_recordings(replace(two_rates(duration=200.0, sensors=["x1", "x2", "x3", "x4"]), lowpass=4.0))
    slow, fast, _ = found.recordings
    for mode in found.followed:  # the strongest two, whose frequencies 200 s and 1 % noise tell to per milles
        pair = [each.identified.frequencies[each.chosen[mode]] for each in (slow, fast)]
        assert pair[0] == pytest.approx(pair[1], rel=0.005)


@pytest.mark.parametrize("rate", [25.0, 20.0])
def test_what_thinning_would_spoil_is_refused(rate: float) -> None:
    """Rates that are no multiples, and forces, which go on above the low-pass."""
    given = replace(two_rates(second=rate), lowpass=4.0)
    if rate == 20.0:
        fast = given.recordings[1]
        load = Load(1, "x", np.ones(fast.data.shape[1]))
        given = replace(given, recordings=(given.recordings[0], replace(fast, loads=(load,))))
    with pytest.raises(InputError, match="different sampling rates"):
        given.of_one_rate("a test")


def test_one_rate_that_recordings_state_is_the_dataset_s() -> None:
    alone = Dataset(four_dof(), 10.0, paper_sensors(), (Recording("r", np.ones((1, 40, 5)), sampling_rate=20.0),))
    assert alone.of_one_rate("a test").sampling_rate == 20.0
    assert alone.of_one_rate("a test").recordings[0].sampling_rate is None


@pytest.mark.slow
def test_modes_are_identified_at_each_recording_s_own_rate() -> None:
    """The same chain at 10 and 20 Hz has the same modes; at the other's rate they would be twice or half as fast."""
    found = diagnose_modes(two_rates())
    assert found.verdict is Verdict.NOTHING_WRONG
    assert {mode.recording for mode in found.modes} == {"motion_1", "fast"}
    for mode in found.modes:
        assert mode.drawn == pytest.approx(mode.measured, rel=0.01)
