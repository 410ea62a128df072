"""A comparison says which sensors were clipped, and draws channels of several quantities side by side."""

from dataclasses import replace

import numpy as np

from fe_models.recordings import Dataset, Recording, Sensor
from hybrid.identification.clipped_channels import clipped_notes, clipped_samples
from hybrid.identification.dataset_comparison import compare_dataset
from tests.hybrid_problems import chain_dataset, chain_modes

SINE = np.sin(0.05 * np.arange(2000))


def test_a_smooth_motion_is_not_clipped_and_one_that_is_cut_off_is() -> None:
    assert clipped_samples(SINE) == 0
    cut = np.clip(SINE, -0.9, 2.0)
    assert clipped_samples(cut) == np.sum(cut == -0.9) > 100
    assert clipped_samples(np.sign(SINE)) == 0  # a channel of few levels rests at its largest one in any case


def test_a_comparison_notes_the_sensors_that_are_clipped_and_where() -> None:
    dataset = chain_dataset(chain_modes(), noise=0.005, realisations=1, samples=500)
    (first, *others), sensors = dataset.recordings[:2], dataset.sensors
    assert compare_dataset(replace(dataset, recordings=(first,))).notes == ()
    data = first.data.copy()
    data[..., 1] = np.clip(data[..., 1], -0.3 * data[..., 1].max(), 0.3 * data[..., 1].max())
    found = compare_dataset(replace(dataset, recordings=(replace(first, data=data), *others)))
    (note,) = found.notes
    assert note.startswith(f"{sensors[1].name} is clipped in {first.name} (")


def test_all_motions_of_a_recording_count() -> None:
    sensor = Sensor("a", 1, "x", "acceleration", "m/s^2")
    cut = np.clip(SINE, -0.5, 0.5)
    data = np.stack([SINE, cut, cut])[..., None]
    dataset = Dataset(None, 20.0, (sensor,), (Recording("r", data),))  # type: ignore[arg-type]
    (note,) = clipped_notes(dataset)
    assert f"r ({2 * int(np.sum(np.abs(cut) == 0.5))} samples)" in note
