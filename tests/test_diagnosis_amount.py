"""Long recordings and very many motions: a diagnosis goes by a part of them, says so, and stays within its memory."""

import resource
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from fe_models.built_in.four_dof import four_dof
from fe_models.files.dataset_file import save_dataset
from fe_models.four_dof_data import paper_dataset
from fe_models.recordings import Dataset, Load, Recording
from hybrid.diagnosis.recorded.amount import limited, memory_gb, most_samples
from hybrid.diagnosis.recorded.config import AMOUNT
from tests.hybrid_problems import MEASURED, SENSORS

RATE = 2.0
FOUR = tuple(SENSORS[i] for i in MEASURED)
RNG = np.random.default_rng(0)


def recording(name: str, motions: int, samples: int, role: str = "train", ambient: bool = False) -> Recording:
    """Noise in four channels that dies away, or goes on where it is said to be ``ambient``."""
    data = RNG.standard_normal((motions, samples, 4))
    if ambient:  # white forces on a mode with 1 % of damping
        data = lfilter([1.0], [1.0, -1.2, 0.98], data, axis=1)
        return Recording(name, data, role, excitation="ambient")  # type: ignore[arg-type]
    fall = np.exp(-np.arange(samples) / (0.1 * samples))
    return Recording(name, data * fall[:, None], role, excitation="free")  # type: ignore[arg-type]


def dataset(*recordings: Recording) -> Dataset:
    return Dataset(four_dof(), RATE, FOUR, recordings)


def sizes(given: Dataset) -> dict[str, tuple[int, ...]]:
    return {each.name: each.data.shape[:2] for each in given.recordings}


def test_usual_measurements_are_used_whole() -> None:
    """The very same object: nothing that follows can differ. With many sensors, too."""
    for given in (
        dataset(recording("a", 1, 20_000), recording("b", 3, 20_000), recording("t", 1, 20_000, "test")),
        replace(dataset(recording("a", 1, 20_000)), sensors=FOUR * 30),
    ):
        found, notes = limited(given)
        assert found is given
        assert notes == ()


def test_of_many_motions_some_at_even_distances_are_used() -> None:
    given = dataset(recording("train", 1000, 501), recording("test", 300, 501, "test"))
    found, (note, *more) = limited(given)
    assert sizes(found)["train"] == (most_samples(4) // 501, 501)
    which = [
        int(np.flatnonzero((given.recordings[0].data == motion).all(axis=(1, 2)))[0])
        for motion in found.recordings[0].data
    ]
    assert which[0] == 0
    assert which[-1] == 999
    assert set(np.diff(which)) <= {5, 6}  # a motion in five
    assert (
        note
        == f"of train {len(which)} of the 1,000 motions are used: more of the same tell little more, and take memory"
    )
    assert len(more) == 1  # the tests: a few too many, too
    assert limited(found) == (found, ())


def test_of_a_long_recording_the_first_part_is_used_with_its_load() -> None:
    long = replace(recording("long", 1, 300_000), loads=(Load(1, "x", np.arange(300_000.0)),), excitation="measured")
    given = dataset(long, recording("short", 1, 4_000), recording("t", 1, 1_000, "test"))
    found, (note,) = limited(given)
    length = most_samples(4) - 4_000  # the short one is used whole
    assert sizes(found) == {"long": (1, length), "short": (1, 4_000), "t": (1, 1_000)}
    np.testing.assert_array_equal(found.recordings[0].data, long.data[:, :length])
    np.testing.assert_array_equal(found.recordings[0].loads[0].values, np.arange(length))
    assert note.startswith("of long the first 96,000 of 300,000 samples are used")


def test_each_recording_has_a_say() -> None:
    """However many there are, of usual length: what was lost before one of them must be found."""
    given = dataset(*(recording(f"r{i}", 1, 20_000) for i in range(30)))
    found, notes = limited(given)
    assert set(sizes(found).values()) == {(1, AMOUNT.shortest)}
    assert len(notes) == 30


def test_ambient_recordings_are_used_whole() -> None:
    """Said to be, or seen to go on."""
    ambient = recording("wind", 1, 200_000, ambient=True)
    for given in (dataset(ambient), dataset(replace(ambient, excitation=None))):
        assert limited(given)[0].recordings == given.recordings


def test_memory_is_foretold() -> None:
    little, much = dataset(recording("a", 1, 1_000)), dataset(recording("a", 1, 1_000_000))
    assert memory_gb(little) < 0.5
    assert memory_gb(little) < memory_gb(limited(much)[0]) < 4.0


@pytest.mark.slow
def test_a_million_samples_by_four_sensors_take_less_than_four_gigabytes(tmp_path: Path) -> None:
    """The program's own motions, two and a half times as many as its default."""
    given = paper_dataset(0.5, realisations=2500, progress=False)
    file = save_dataset(given, tmp_path)
    code = "from hybrid.commands.app import app; app()"
    found = subprocess.run(
        [sys.executable, "-c", code, "diagnose", str(file), "--out", str(tmp_path / "out")],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "of the 2,000 motions are used" in found.stderr
    assert "A cubic spring of 0." in found.stdout
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < 4 * 2**20  # KiB
