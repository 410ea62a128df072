"""The first look at a recording file: its channels, their faults, what moved the structure, a dataset to start from."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter
from typer.testing import CliRunner

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset
from fe_models.files.signals import read_signals
from fe_models.files.structure_file import save_structure
from hybrid.commands.app import app
from hybrid.inspection.channel_facts import ChannelFacts, channel_facts
from hybrid.inspection.inspection import inspect_file
from hybrid.inspection.inspection_report import _drawn, as_json, describe, faults_of
from hybrid.inspection.likely_excitation import Moved, likely_excitation
from hybrid.inspection.starter_dataset import starter_dataset
from tests.sample_dataset import MAST, NAMES, RATE, free_decay
from tests.test_recording_formats import write_mat_73, write_tdms, write_uff

SAMPLES = 6000
TIME = np.arange(SAMPLES) / RATE
NOISE = np.random.default_rng(0).standard_normal((SAMPLES, 3))
AMBIENT = np.asarray(lfilter([1.0], [1.0, -1.94, 0.98], NOISE, axis=0))  # one mode near 4 Hz, driven by white noise


@pytest.mark.parametrize("motion", [AMBIENT, np.zeros((0, 3)), np.full((SAMPLES, 3), np.nan)])
def test_a_channel_without_any_sample_leaves_the_guess_as_it_is(motion: FloatArray) -> None:
    """Quietly: warnings are errors here."""
    dead = np.full((len(motion), 1), np.nan)
    names, units = ["a", "b", "c", "d"], ["m/s^2"] * 4
    guess = likely_excitation(names, units, np.hstack([motion, dead]))
    assert guess == likely_excitation(names[:3], units[:3], motion)
    assert guess.moved is (Moved.AMBIENT if np.isfinite(motion).any() else Moved.UNCLEAR)


def facts(values: FloatArray) -> ChannelFacts:
    return channel_facts("a", "m/s^2", values, RATE)


def decay(begins: float = 0.0, damping: float = 0.02, frequency: float = 2.0) -> FloatArray:
    """A decay in three channels, (sample, channel), with a thousandth of noise."""
    time = np.maximum(TIME - begins, 0.0)[:, None]
    wave = np.exp(-damping * 2 * np.pi * frequency * time) * np.cos(2 * np.pi * frequency * time + np.arange(3))
    return np.asarray(wave * (TIME[:, None] >= begins) + 1e-3 * NOISE)


def test_a_sound_channel_has_its_range_and_its_peak_and_no_fault() -> None:
    found = facts(AMBIENT[:, 0])
    assert (found.lowest, found.highest) == (AMBIENT[:, 0].min(), AMBIENT[:, 0].max())
    assert found.deviation == pytest.approx(AMBIENT[:, 0].std())
    assert faults_of(found, RATE) == []
    (peak,) = found.peaks
    assert peak == pytest.approx(np.angle(np.roots([1.0, -1.94, 0.98])[0]) * RATE / (2 * np.pi), abs=0.2)  # a line


def test_lost_samples_and_gaps_are_counted() -> None:
    values = AMBIENT[:, 0].copy()
    values[100] = values[200:250] = np.nan
    found = facts(values)
    assert (found.lost, found.gaps, found.longest_gap) == (51, 2, 50)
    assert faults_of(found, RATE) == ["51 samples are lost in 2 gaps, the longest of 0.5 s"]
    assert faults_of(facts(np.full(SAMPLES, np.nan)), RATE) == ["dead: it has no sample at all"]


def test_clipping_is_found_and_a_coarse_sensor_is_not_blamed() -> None:
    limit = 1.5 * AMBIENT[:, 0].std()
    (fault,) = faults_of(facts(np.clip(AMBIENT[:, 0], -limit, limit)), RATE)
    assert fault.startswith("clipped: ")
    steps = np.round(AMBIENT[:, 0] / AMBIENT[:, 0].std())
    assert not any("clipped" in fault for fault in faults_of(facts(steps), RATE))


@pytest.mark.parametrize("frequency", [1.837, 6.259, 11.03])
def test_a_peak_is_told_between_the_lines_of_its_spectrum(frequency: float) -> None:
    (peak,) = facts(decay(damping=0.002, frequency=frequency)[:, 0]).peaks
    assert peak == pytest.approx(frequency, abs=0.02)  # a tenth of a line


def test_a_channel_that_shows_nothing_of_the_others_is_named(tmp_path: Path) -> None:
    values = np.column_stack([AMBIENT, 1e-3 * np.random.default_rng(1).standard_normal(SAMPLES)])
    file = tmp_path / "monday.csv"
    np.savetxt(file, values, delimiter=",", header="a,b,c,loose", comments="")
    found = inspect_file(file, sampling_rate=RATE)
    assert found.apart == ("loose",)
    assert "loose: shows none of the peaks of the other channels (" in describe(found)
    assert as_json(found)["without_common_peaks"] == ["loose"]
    np.savetxt(file, AMBIENT, delimiter=",", header="a,b,c", comments="")
    assert inspect_file(file, sampling_rate=RATE).apart == ()
    np.savetxt(file, values[:, 2:], delimiter=",", header="c,loose", comments="")
    assert inspect_file(file, sampling_rate=RATE).apart == ()  # of two nobody knows which one is right


def test_a_force_that_rests_is_not_stuck(tmp_path: Path) -> None:
    force = np.where(np.abs(TIME - 2.0) < 0.02, 100.0, 0.0)
    file = tmp_path / "knock.csv"
    np.savetxt(file, np.column_stack([decay(2.0), force]), delimiter=",", header="a,b,c,hammer", comments="")
    found = inspect_file(file, sampling_rate=RATE)
    assert found.guess.channels == (3,)
    assert "stuck" not in describe(found)


def test_a_sensor_that_was_stuck_or_is_dead_is_named() -> None:
    values = AMBIENT[:, 0].copy()
    values[1000:1500] = values[1000]
    assert faults_of(facts(values), RATE) == ["stuck: it does not change for 5 s"]
    assert faults_of(facts(np.full(SAMPLES, 3.0)), None) == ["dead: it never changes"]


@pytest.mark.parametrize("drift", [-20.0, 20.0])
def test_a_drift_is_told_with_its_sign_and_noise_is_none(drift: float) -> None:
    values = AMBIENT[:, 1] + drift * TIME / TIME[-1]
    # what a few slow periods of the noise add: its deviation over the root of some tens of independent values
    assert facts(values).drift == pytest.approx(drift, abs=0.1 * AMBIENT[:, 1].std())
    assert facts(AMBIENT[:, 1]).drift == 0.0


def shaken() -> FloatArray:
    """Strong motion that builds up over six seconds and dies away."""
    envelope = (TIME / 8.0) ** 2 * np.exp(2 - 2 * TIME / 8.0)
    return np.asarray(AMBIENT * envelope[:, None] + 1e-3 * NOISE)


@pytest.mark.parametrize(
    ("values", "moved"),
    [
        (decay(), Moved.FREE),
        (decay(begins=5.0), Moved.FREE),
        (decay(damping=0.002), Moved.FREE),
        (decay() + decay(begins=20.0) + decay(begins=40.0), Moved.DECAYS),
        (AMBIENT, Moved.AMBIENT),
        (NOISE, Moved.AMBIENT),
        (np.sin(2 * np.pi * TIME)[:, None] + 0.01 * NOISE, Moved.STEADY),
        (shaken(), Moved.EARTHQUAKE),
        (np.zeros((SAMPLES, 2)), Moved.UNCLEAR),
    ],
)
def test_what_moved_the_structure_is_guessed(values: FloatArray, moved: Moved) -> None:
    names = [f"A{number}" for number in range(values.shape[1])]
    assert likely_excitation(names, ["m/s^2"] * len(names), values).moved is moved


@pytest.mark.parametrize(
    ("names", "units", "moved", "channels"),
    [
        (["a1", "hammer", "a2"], ["", "", ""], Moved.MEASURED, (1,)),
        (["a1", "a2", "ch3"], ["g", "g", "kN"], Moved.MEASURED, (2,)),
        (["ground", "a2", "a3"], ["g", "g", "g"], Moved.BASE, (0,)),
        (["load cell plate", "a2", "a3"], ["m/s^2", "g", "g"], Moved.AMBIENT, ()),  # its unit knows better
    ],
)
def test_a_force_or_a_moving_base_is_told_by_name_or_unit(
    names: list[str], units: list[str], moved: Moved, channels: tuple[int, ...]
) -> None:
    guess = likely_excitation(names, units, AMBIENT)
    assert (guess.moved, guess.channels) == (moved, channels)


def write(path: Path) -> None:
    """The sample's free decay in the format that the name says."""
    data = free_decay(1)
    if path.suffix == ".uff":
        write_uff(path, data, int("b" in path.stem))
    elif path.suffix == ".tdms":
        write_tdms(path, data)
    elif path.suffix == ".mat":
        write_mat_73(path, {"acc": data, "Fs": np.array([[RATE]]), "other": np.ones(5)})
    elif path.suffix == ".npz":
        np.savez(path, data=data, dt=1 / RATE)
    elif path.suffix == ".npy":
        np.save(path, data)
    else:
        rows = [";".join(f"{value:.9f}" for value in (1000 * n / RATE, *row)) for n, row in enumerate(data)]
        path.write_text("\n".join(["Time;a2;a3;d3", "ms;m/s^2;m/s^2;-", *rows]))


FILES = ["r.csv", "r.txt", "r.uff", "b.uff", "r.tdms", "r.mat", "r.npz", "r.npy"]


@pytest.mark.parametrize("name", FILES)
def test_each_format_is_inspected_and_its_starter_is_a_dataset(tmp_path: Path, name: str) -> None:
    write(tmp_path / name)
    found = inspect_file(tmp_path / name, sampling_rate=RATE if name.endswith("npy") else None)
    signals = found.signals
    assert signals.sampling_rate == pytest.approx(RATE, rel=1e-4)
    assert signals.values.shape == (400, 3)
    if signals.key is None:
        assert sorted(signals.names) == sorted(NAMES)
        assert dict(zip(signals.names, signals.units, strict=True))["a2"] == "m/s^2"
    assert found.guess.moved is Moved.FREE
    assert f"{name}: 3 channels of 400 samples at 100 Hz" in describe(found)
    json.dumps(as_json(found), allow_nan=False)
    save_structure(MAST, tmp_path / "model.toml")
    (tmp_path / "start.toml").write_text(
        starter_dataset(signals, found.facts, found.guess, name).replace("node = 1", "node = 3")
    )
    dataset = load_dataset(tmp_path / "start.toml")
    assert len(dataset.sensors) == 3
    assert dataset.recordings[0].excitation == "free"
    to_si = [9.80665 if unit == "g" else 1.0 for unit in signals.units]
    np.testing.assert_allclose(dataset.recordings[0].data[0], signals.values * to_si)


@pytest.mark.parametrize(("column", "words"), [("force [kN]", "recordings.loads"), ("ground [g]", "recordings.base")])
def test_a_starter_names_the_force_or_the_base_motion(tmp_path: Path, column: str, words: str) -> None:
    rows = [f"{n / RATE},{value:.6f},{n % 7}" for n, value in enumerate(AMBIENT[:500, 0])]
    (tmp_path / "r.csv").write_text("\n".join([f"time,a2 [m/s^2],{column}", *rows]))
    found = inspect_file(tmp_path / "r.csv")
    text = starter_dataset(found.signals, found.facts, found.guess, "r.csv")
    assert f"[[{words}]]" in text
    save_structure(MAST, tmp_path / "model.toml")
    (tmp_path / "start.toml").write_text(text.replace("node = 1", "node = 3"))
    (recording,) = load_dataset(tmp_path / "start.toml").recordings
    (values,) = recording.driving
    factor = 1000.0 if "kN" in column else 9.80665
    np.testing.assert_allclose(values, factor * (np.arange(500) % 7))


def test_a_dead_channel_is_left_out_of_the_starter(tmp_path: Path) -> None:
    rows = [f"{value:.6f},0" for value in AMBIENT[:500, 0]]
    (tmp_path / "r.csv").write_text("\n".join(["a2,a3", *rows]))
    found = inspect_file(tmp_path / "r.csv", sampling_rate=RATE)
    text = starter_dataset(found.signals, found.facts, found.guess, "r.csv")
    assert "# a3 never changes: a dead channel, left out." in text
    save_structure(MAST, tmp_path / "model.toml")
    (tmp_path / "start.toml").write_text(text.replace("node = 1", "node = 3"))
    assert [sensor.name for sensor in load_dataset(tmp_path / "start.toml").sensors] == ["a2"]


def test_what_is_no_number_or_has_no_rate_is_said(tmp_path: Path) -> None:
    rows = [f"2024-05-01 10:00:{n / RATE:06.3f},{value:.6f},ok" for n, value in enumerate(AMBIENT[:500, 0])]
    (tmp_path / "r.csv").write_text("\n".join(["when,a2,status", *rows]))
    found = inspect_file(tmp_path / "r.csv")
    words = describe(found)
    assert "the file does not say its sampling rate" in words
    assert "no numbers: 'when', 'status'" in words
    assert "peaks (cycles a sample)" in words
    assert "# sampling_rate = 100.0   # CHECK" in starter_dataset(found.signals, found.facts, found.guess, "r.csv")


def test_several_arrays_are_named_and_chosen(tmp_path: Path) -> None:
    np.savez(tmp_path / "r.npz", one=AMBIENT[:100], two=AMBIENT.T[:, :50], many=np.zeros((0, 3)))
    assert read_signals(tmp_path / "r.npz").key == "one"
    found = read_signals(tmp_path / "r.npz", "two")
    assert found.values.shape == (50, 3)
    assert any("channels stand in rows" in note for note in found.notes)
    assert any("beside 'two' it holds 'one' 100x3; --key chooses" in note for note in found.notes)
    with pytest.raises(InputError, match="holds no plain array 'three'"):
        read_signals(tmp_path / "r.npz", "three")


def test_the_command_prints_and_writes_and_never_over_a_user_s_file(tmp_path: Path) -> None:
    write(tmp_path / "r.csv")
    run, out = CliRunner().invoke, tmp_path / "out"
    done = run(app, ["inspect", str(tmp_path / "r.csv")])
    assert done.exit_code == 0, done.output
    assert "It looks like a free decay" in done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["r.csv"]
    done = run(app, ["inspect", str(tmp_path / "r.csv"), "--out", str(out), "--quiet"])
    assert done.stdout.split() == [str(out / "dataset.toml")]
    assert {"dataset.toml", "inspection.txt", "inspection.json", "inspection.png"} <= {p.name for p in out.iterdir()}
    assert 'file = "../r.csv"' in (out / "dataset.toml").read_text()
    assert (out / "inspection.png").stat().st_size > 10_000
    (out / "dataset.toml").write_text("my own")
    done = run(app, ["inspect", str(tmp_path / "r.csv"), "--out", str(out)])
    assert done.exit_code == 2
    assert (out / "dataset.toml").read_text() == "my own"


def test_a_long_curve_keeps_its_extremes_and_its_gaps() -> None:
    values = np.zeros(50_000)
    values[[12_345, 40_001]] = 5.0, -7.0
    values[20_000:21_000] = np.nan
    time, drawn = _drawn(values, RATE)
    assert len(drawn) < 10_000
    assert (np.nanmax(drawn), np.nanmin(drawn)) == (5.0, -7.0)
    assert time[np.nanargmax(drawn)] == pytest.approx(123.45, abs=24 / RATE)  # a span
    assert np.isnan(drawn).sum() > 50


def test_the_command_refuses_what_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "r.tdms").write_bytes(b"TDSm")
    for name in ("r.tdms", "gone.csv", "r.xyz"):
        done = CliRunner().invoke(app, ["inspect", str(tmp_path / name)])
        assert done.exit_code == 2
        assert name in done.stderr
        assert "Traceback" not in done.output
