"""Channels that are dead, stuck or saturated, for a while or throughout: what of recordings is used all the same."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.errors import InputError
from hybrid.diagnosis.modes_and_motion.measured_in_dataset import measured_in
from hybrid.diagnosis.recorded.faulty_channels import saturation_levels, stuck_samples, usable
from tests.chain_case import CASE, NAMES, clipped, with_data


def test_channel_that_symmetry_silences_counts_as_dead_where_it_is_silent() -> None:
    """Simulated noise that is a share of each motion would make rounding errors the most exact values of all."""
    silent = np.where(np.arange(5) == NAMES.index("a3"), 1e-12, 1.0) * CASE.recordings[1].data
    sound, (note,) = usable(with_data(CASE, {"r02": silent}))
    assert note == "sensor a3 hardly changes (all of r02): it is left out"
    assert len(sound.sensors) == 4
    quiet = np.where(np.arange(5) == NAMES.index("a3"), 1e-4, 1.0) * CASE.recordings[1].data
    assert usable(with_data(CASE, {"r02": quiet}))[1] == []


def test_recording_in_which_nothing_moves_is_left_out_with_no_sensor() -> None:
    still = with_data(CASE, {"r02": np.zeros_like(CASE.recordings[1].data)})
    sound, (note,) = usable(still)
    assert note == "no sensor changes in r02: left out"
    assert len(sound.sensors) == 5
    assert [r.name for r in sound.recordings] == ["r01", "r03", "r04"]
    motions = np.concatenate([CASE.recordings[1].data, np.zeros_like(CASE.recordings[1].data)])
    sound, (note,) = usable(with_data(CASE, {"r02": motions}))
    assert note == "no sensor changes in 1 of the 2 motions of r02: left out"
    assert len(sound.recordings) == 4


@pytest.mark.parametrize("value", [0.0, np.nan])
def test_modes_of_a_recording_in_which_nothing_moves_are_refused_by_its_name(value: float) -> None:
    """By series it is left out, with the note above."""
    still = with_data(CASE, {"r02": np.full_like(CASE.recordings[1].data, value)})
    with pytest.raises(InputError, match="recording 'r02': no sensor changes in it"):
        measured_in(still, lambda _: None)


def test_recording_in_which_most_sensors_are_dead_is_left_out_rather_than_these() -> None:
    hardly = with_data(CASE, {"r02": np.where(np.arange(5) < 4, 0.0, CASE.recordings[1].data)})
    sound, (note,) = usable(hardly)
    assert note == "most sensors never change in r02: left out"
    assert len(sound.sensors) == 5
    assert [r.name for r in sound.recordings] == ["r01", "r03", "r04"]
    broken = {r.name: np.where(np.arange(5) < 3, 0.0, r.data) for r in CASE.recordings[1:]}  # from the second one on
    sound, _ = usable(with_data(CASE, broken))
    assert len(sound.recordings) == 4  # three sensors take no more with them (in r01) than three recordings would
    assert len(sound.sensors) == 2


def test_sensors_that_are_dead_in_many_recordings_are_left_out_rather_than_these() -> None:
    dead = np.arange(5) < 2
    some = {r.name: np.where(dead, 0.0, r.data) for r in CASE.recordings[1:]}
    sound, notes = usable(with_data(CASE, some))
    assert len(sound.recordings) == 4
    assert len(sound.sensors) == 3
    assert len(notes) == 2


def test_saturated_channel_is_detected_by_its_runs() -> None:
    """The largest values in a row are the end of the sensor; those of coarsely rounded or smooth motion are not."""
    time = np.arange(300) / 10
    decay = np.exp(-0.02 * time) * np.sin(2 * time)
    assert saturation_levels(decay) == []
    assert saturation_levels(np.clip(decay, -2, 0.5)) == [0.5]
    assert saturation_levels(np.clip(decay, -0.6, 0.5)) == [-0.6, 0.5]
    assert saturation_levels(np.round(decay, 1)) == []
    noisy = decay + 0.03 * np.random.default_rng(0).standard_normal(300)
    assert saturation_levels(noisy) == []
    assert saturation_levels(np.clip(noisy, -2, 0.5)) == [0.5]
    fast = np.exp(-0.01 * time) * np.sin(16 * time) + 0.03 * np.random.default_rng(1).standard_normal(300)
    assert saturation_levels(np.clip(fast, -2, 0.7)) == [0.7]  # four samples a period: no two in a row
    assert saturation_levels(np.round(fast, 1)) == []


def test_channel_that_stands_still_for_a_while_is_cut_out_and_said() -> None:
    """As a logger that repeats its last value; coarsely rounded values repeat, too."""
    column = NAMES.index("a1")
    data = CASE.recordings[0].data.copy()
    data[0, 50:70, column] = data[0, 50, column]
    sound, (note,) = usable(with_data(CASE, {"r01": data}))
    assert note == "sensor a1 stands still (20 samples of r01): r01 used from there on"
    np.testing.assert_array_equal(sound.recordings[0].data, data[:, 70:])
    coarse = CASE.recordings[0].data[0, :, column]
    coarse = np.round(coarse / coarse.std()) * coarse.std()
    assert not stuck_samples(coarse).any()
    time = np.arange(400)
    assert not stuck_samples(np.round(np.exp(-0.05 * time) * np.sin(time), 4)).any()  # zeros once it has died away
    np.testing.assert_array_equal(np.flatnonzero(stuck_samples(data[0, :, column])), np.arange(50, 70))


def test_recordings_are_used_from_behind_a_few_saturated_samples() -> None:
    data = clipped(CASE.recordings[0].data, "a1", 0.7)
    column = NAMES.index("a1")
    bad = np.flatnonzero(np.abs(data[0, :, column]) == np.abs(data[0, :, column]).max())
    sound, notes = usable(with_data(CASE, {"r01": data}))
    assert len(sound.sensors) == 5
    np.testing.assert_array_equal(sound.recordings[0].data, data[:, bad[-1] + 1 :])
    np.testing.assert_array_equal(sound.recordings[1].data, CASE.recordings[1].data)
    (note,) = notes
    assert f"{len(bad)} samples of r01" in note
    assert "a1" in note


def test_channel_that_is_always_saturated_is_left_out() -> None:
    small = {r.name: clipped(r.data, "a4", 0.02) for r in CASE.recordings}
    sound, notes = usable(with_data(CASE, small))
    assert [sensor.name for sensor in sound.sensors] == ["x4", "a1", "a3", "a2"]
    assert sound.recordings[0].data.shape == (1, 201, 4)
    assert notes[0].endswith("it is left out")


def test_a_channel_that_is_dead_in_one_recording_may_be_saturated_in_the_others() -> None:
    column = NAMES.index("a1")
    dead = CASE.recordings[0].data * (np.arange(5) != column)
    small = {r.name: clipped(r.data, "a1", 0.02) for r in CASE.recordings[1:]}
    sound, notes = usable(with_data(CASE, {**small, "r01": dead}))
    assert "a1" not in [sensor.name for sensor in sound.sensors]
    assert "never changes or is saturated at" in notes[0]


def test_many_levels_at_which_a_channel_ends_are_reported_by_their_range() -> None:
    """Recordings that were scaled one by one end at a level each."""
    small = {r.name: clipped(r.data, "a4", 0.01 * number) for number, r in enumerate(CASE.recordings, 1)}
    levels = [float(f(data[..., NAMES.index("a4")])) for data in small.values() for f in (np.min, np.max)]
    _, (note,) = usable(with_data(CASE, small))
    assert f"is saturated at 8 levels from {min(levels):.4g} to {max(levels):.4g} (" in note


def test_sound_data_stay_as_they_are() -> None:
    sound, notes = usable(CASE)
    assert sound is CASE
    assert notes == []


def test_note_tells_recordings_that_are_left_out_from_those_that_are_cut() -> None:
    """A dead channel spoils the whole of its recording, a saturated one its beginning."""
    few = replace(CASE, sensors=CASE.sensors[:3])  # a sensor of many is left out, as that loses less
    few = with_data(few, {r.name: r.data[..., :3] for r in CASE.recordings})
    column = np.arange(3) == NAMES.index("a3")
    dead = {few.recordings[0].name: np.where(column, 0.0, few.recordings[0].data)}
    kept, notes = usable(with_data(few, dead))
    assert [r.name for r in kept.recordings] == [r.name for r in CASE.recordings[1:]]
    assert notes[0].endswith("r01 left out")
    both = dead[few.recordings[0].name].copy()
    both[..., 0] = np.clip(both[..., 0], -0.9 * both[..., 0].max(), 0.9 * both[..., 0].max())
    for note in usable(with_data(few, {few.recordings[0].name: both}))[1]:  # whatever is wrong with it besides
        assert note.endswith("r01 left out")
    late = {CASE.recordings[1].name: clipped(CASE.recordings[1].data, "a3", 0.9)}
    assert usable(with_data(CASE, late))[1][0].endswith("r02 used from there on")
