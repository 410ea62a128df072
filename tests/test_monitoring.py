"""Structures that are watched: what is kept, new recordings, alarms and their diagnosis."""

import json
import os
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset
from fe_models.files.structure_file import save_structure
from fe_models.recordings import Dataset
from hybrid.commands import watch as door
from hybrid.commands.app import app
from hybrid.monitoring.observation import Kept, SeenMode, Standing, load_kept
from hybrid.monitoring.page import standing_of, watch_page
from hybrid.monitoring.station import load_station
from hybrid.monitoring.watching import PENDING, Watch, accepted, new_alarms
from hybrid.report.rendering import rendered
from tests.pages import Reader
from tests.sample_dataset import MAST, RATE, free_decay
from tests.test_control_chart import FREQUENCIES, observed

STATION = """schema = 1
model = "mast.toml"
sampling_rate = 100.0
sensors = [
    { name = "a2", node = 2, direction = "x", quantity = "acceleration", unit = "m/s^2" },
    { name = "a3", node = 3, direction = "x", quantity = "acceleration", unit = "m/s^2" },
    { name = "d3", node = 3, direction = "y", quantity = "displacement", unit = "1" },
]
recordings = [{ name = "first", file = "first.npz", key = "data" }]
"""


def record(folder: Path, name: str, seed: int, age: float = 100.0) -> Path:
    """Write a recording that was whole ``age`` s ago."""
    path = folder / f"{name}.npz"
    np.savez(path, data=free_decay(seed))
    os.utime(path, (time.time() - age,) * 2)
    return path


@pytest.fixture
def place(tmp_path: Path) -> Path:
    folder = tmp_path / "bridge"
    folder.mkdir()
    save_structure(MAST, folder / "mast.toml")
    (folder / "dataset.toml").write_text(STATION)
    record(folder, "first", 1)
    return folder


def test_recordings_that_come_are_read_as_the_first_one_is(place: Path) -> None:
    second = record(place, "second", 2, age=50.0)
    record(place, "third", 3, age=60.0)
    record(place, "growing", 4, age=1.0)
    (place / "notes.md").write_text("no recording")
    station = load_station(place)
    assert [own.name for own in station.listed] == ["first"]
    found = station.arrived(10.0, time.time())
    assert [own.name for own in found] == ["third", "second"]  # in the order in which they came
    data = station.dataset([found[1]])
    assert [own.name for own in data.recordings] == ["second"]
    np.testing.assert_array_equal(data.recordings[0].data[0], np.load(second)["data"])
    assert data.sampling_rate == RATE


def test_what_is_no_station_is_told(tmp_path: Path, place: Path) -> None:
    with pytest.raises(InputError, match="no such folder"):
        load_station(tmp_path / "none")
    with pytest.raises(InputError, match=r"dataset\.toml: no such file"):
        load_station(tmp_path)


# The watch, with modes as the file says


def modes_in(dataset: Dataset) -> tuple[SeenMode, ...]:
    """What is identified in tests: usual modes, the second one 4 % lower where a recording is called so."""
    name = dataset.recordings[0].name
    rng = np.random.default_rng(sum(map(ord, name)))
    if "silent" in name:
        return ()
    lower = [1, 0.96, 1] if "changed" in name else [0.8, 1, 1] if "fallen" in name else [1, 1, 1]
    return observed(name, FREQUENCIES * lower * np.exp(1e-3 * rng.standard_normal(3))).modes


def looked(watch: Watch, out: Path) -> Kept:
    """Look at all that is new, as the command does."""
    kept = load_kept(out, watch.station.digests)
    for own in watch.missing(kept, 10.0, time.time()):
        kept = watch.looked_at(kept, own)
    return watch.diagnosed(kept)


def usual(place: Path, count: int = 6) -> None:
    for k in range(count):
        record(place, f"usual{k}", k, age=90.0 - k)


def test_recordings_are_learned_from_then_judged_and_a_change_is_diagnosed_once(place: Path, tmp_path: Path) -> None:
    diagnosed: list[tuple[list[str], Path]] = []

    def diagnose(file: Path, folder: Path) -> None:
        data = load_station(place, file)
        diagnosed.append(([own.name for own in data.listed], folder))

    out = tmp_path / "out"
    out.mkdir()
    watch = Watch(load_station(place), out, 5, modes_in, diagnose)
    usual(place)
    kept = looked(watch, out)
    standings = [own.standing.value for own in kept.observations]
    assert standings == ["history"] * 5 + ["as usual"] * 2
    assert standing_of(kept, 5)[0] == "As usual"
    record(place, "changed1", 1, age=20.0)
    record(place, "changed2", 2, age=19.0)
    after = looked(watch, out)
    assert [own.standing.value for own in after.observations[7:]] == ["alarm", "alarm"]
    assert [own.name for own in new_alarms(kept.observations, after.observations)] == ["changed1", "changed2"]
    assert diagnosed == [(["usual3", "usual4", "usual5", "changed1"], out / "change-changed1")]
    assert [own.diagnosis for own in after.observations[7:]] == ["change-changed1", ""]
    assert looked(watch, out) == after  # nothing is new
    assert len(diagnosed) == 1
    page = rendered(watch_page(after, "bridge", 5))
    assert Reader(page).elements
    assert "not as it was, from recording changed1 on, and 1 more since" in page
    assert '<a href="change-changed1/report.html">' in page


@pytest.mark.parametrize("name", ["fallen", "silent"])
def test_a_recording_of_a_far_other_state_is_an_alarm_and_joins_no_history(
    place: Path, tmp_path: Path, name: str
) -> None:
    """One frequency is 20 % lower, or no mode is seen at all."""
    out = tmp_path / "out"
    out.mkdir()
    usual(place)
    record(place, name, 1, age=20.0)
    watch = Watch(load_station(place), out, 5, modes_in)
    kept = looked(watch, out)
    assert kept.observations[-1].standing is Standing.ALARM
    assert name not in [own.name for own in kept.history]
    assert f"from recording {name} on" in rendered(watch_page(kept, "bridge", 5))


def test_a_recording_without_modes_is_nothing_to_learn_from(place: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    record(place, "silent", 1, age=20.0)
    last = looked(Watch(load_station(place), out, 5, modes_in), out).observations[-1]
    assert (last.standing, last.words) == (Standing.UNREADABLE, ("no natural mode is seen in it",))


def test_a_watch_that_is_killed_goes_on(place: Path, tmp_path: Path) -> None:
    """Between two recordings, and while a change is diagnosed."""
    out = tmp_path / "out"
    out.mkdir()
    usual(place)
    record(place, "changed", 1, age=20.0)
    watch = Watch(load_station(place), out, 5, modes_in, lambda file, folder: None)
    kept = load_kept(out, watch.station.digests)
    for own in watch.missing(kept, 10.0, time.time())[:3]:
        watch.looked_at(load_kept(out, watch.station.digests), own)
    kept = load_kept(out, watch.station.digests)
    assert len(kept.observations) == 3
    for own in watch.missing(kept, 10.0, time.time()):
        kept = watch.looked_at(kept, own)  # and killed before it is diagnosed
    assert kept.observations[-1].diagnosis == PENDING
    assert looked(watch, out).observations[-1].diagnosis == "change-changed"


def test_an_alarm_whose_diagnosis_was_stopped_is_told_when_that_is_done(place: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    usual(place)
    record(place, "changed", 1, age=20.0)
    watch = Watch(load_station(place), out, 5, modes_in, lambda file, folder: None)
    stopped = load_kept(out, watch.station.digests)
    for own in watch.missing(stopped, 10.0, time.time()):
        stopped = watch.looked_at(stopped, own)
    after = looked(watch, out)
    assert [own.name for own in new_alarms(stopped.observations, after.observations)] == ["changed"]
    assert not new_alarms(after.observations, looked(watch, out).observations)


def test_a_recording_whose_modes_cannot_be_identified_is_passed_by(place: Path, tmp_path: Path) -> None:
    def failing(dataset: Dataset) -> tuple[SeenMode, ...]:
        if dataset.recordings[0].name == "odd":
            raise np.linalg.LinAlgError("SVD did not converge")
        return modes_in(dataset)

    out = tmp_path / "out"
    out.mkdir()
    usual(place)
    record(place, "odd", 1, age=20.0)
    kept = looked(Watch(load_station(place), out, 5, failing, lambda file, folder: None), out)
    assert (kept.observations[-1].name, kept.observations[-1].standing) == ("odd", Standing.UNREADABLE)
    assert "SVD did not converge" in kept.observations[-1].words[0]


def test_a_diagnosis_that_fails_leaves_the_alarm(place: Path, tmp_path: Path) -> None:
    def failing(file: Path, folder: Path) -> None:
        raise RuntimeError("of its own")

    out = tmp_path / "out"
    out.mkdir()
    usual(place)
    record(place, "changed", 1, age=20.0)
    last = looked(Watch(load_station(place), out, 5, modes_in, failing), out).observations[-1]
    assert (last.standing, last.diagnosis) == (Standing.ALARM, "")
    assert last.words[-1] == "the change could not be diagnosed (RuntimeError: of its own)"


def test_an_alarm_that_is_accepted_begins_a_new_history(place: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    usual(place)
    watch = Watch(load_station(place), out, 5, modes_in)
    with pytest.raises(InputError, match="no alarm to accept"):
        accepted(looked(watch, out))
    record(place, "changed1", 1, age=20.0)
    kept = accepted(looked(watch, out))
    assert (kept.state, [own.name for own in kept.history]) == (2, ["changed1"])
    assert standing_of(kept, 5)[0] == "Learning"


def test_a_recording_that_cannot_be_read_stops_no_other_and_is_tried_again(place: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    bad = place / "bad.npz"
    np.savez(bad, data=free_decay(1)[:, :2])
    os.utime(bad, (time.time() - 95,) * 2)
    usual(place, 1)
    watch = Watch(load_station(place), out, 5, modes_in)
    kept = looked(watch, out)
    assert [own.standing.value for own in kept.observations] == ["history", "not readable", "history"]
    assert "2 columns for 3 sensors" in kept.observations[1].words[0]
    assert looked(watch, out) == kept  # not while it is as it was
    record(place, "bad", 5, age=30.0)
    assert [own.name for own in looked(watch, out).observations] == ["first", "usual0", "bad"]


def test_the_history_of_another_structure_is_refused(place: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    looked(Watch(load_station(place), out, 5, modes_in), out)
    (place / "dataset.toml").write_text(STATION.replace("sampling_rate = 100.0", "sampling_rate = 50.0"))
    with pytest.raises(InputError, match="began with another sampling rate; give another --out"):
        load_kept(out, load_station(place).digests)
    (out / "watch.json").write_text('{"mine": 1}')
    with pytest.raises(InputError, match="is no history that this version reads"):
        load_kept(out, load_station(place).digests)


def test_what_differs_from_what_the_history_began_with_is_named(place: Path) -> None:
    """The content of the model's file, the sensors and the rates; not the recordings listed."""
    begun = load_station(place).digests
    record(place, "second", 2)
    table = '{ name = "second", file = "second.npz", key = "data" }'
    changes = {
        "recordings = [": f"recordings = [{table}, ",
        "sampling_rate = 100.0": "sampling_rate = 100.0\nlowpass = 40.0",
        'name = "a2", node = 2': 'name = "b2", node = 2',
    }
    found = []
    for old, new in changes.items():
        (place / "dataset.toml").write_text(STATION.replace(old, new))
        found.append([name for name, own in load_station(place).digests.items() if own != begun[name]])
    (place / "dataset.toml").write_text(STATION)
    (place / "mast.toml").write_text((place / "mast.toml").read_text() + "\n# of 1987\n")
    found.append([name for name, own in load_station(place).digests.items() if own != begun[name]])
    assert found == [[], ["low-pass frequency"], ["list of sensors"], ["model"]]


def test_a_folder_that_is_moved_keeps_its_history(place: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    usual(place)
    kept = looked(Watch(load_station(place), out, 5, modes_in), out)
    moved = place.rename(tmp_path / "elsewhere")
    station = load_station(moved)
    assert looked(Watch(station, out, 5, modes_in), out) == kept
    record(moved, "changed", 1, age=20.0)
    diagnosed: list[list[str]] = []
    watch = Watch(station, out, 5, modes_in, lambda file, _: diagnosed.append(names_in(file)))
    looked(watch, out)
    assert diagnosed == [["usual3", "usual4", "usual5", "changed"]]


def names_in(file: Path) -> list[str]:
    return [own.name for own in load_dataset(file).recordings]


@pytest.mark.slow
def test_recordings_that_were_looked_at_may_be_archived(
    place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Among them the one that is listed; one that is listed later and not there has a row."""
    monkeypatch.setattr("hybrid.monitoring.watching.modes_of", modes_in)
    usual(place)
    words = ["watch", str(place), "--out", str(tmp_path / "out"), "--once", "--no-diagnose"]
    assert CliRunner().invoke(app, words).exit_code == 0
    (place / "first.npz").unlink()
    (place / "usual0.npz").unlink()
    more = '{ name = "late", file = "late.npz", key = "data" }'
    (place / "dataset.toml").write_text(STATION.replace('"data" }]', f'"data" }}, {more}]'))
    record(place, "usual9", 9, age=20.0)
    ran = CliRunner().invoke(app, words)
    assert ran.exit_code == 0, ran.output
    assert "8 recordings make its history" in ran.stdout
    kept = json.loads((tmp_path / "out" / "watch.json").read_text())["observations"]
    (row,) = (own for own in kept if own["name"] == "late")
    assert row["standing"] == "not readable"
    assert "no such file" in row["words"][0]
    record(place, "late", 10, age=20.0)
    assert CliRunner().invoke(app, words).exit_code == 0
    assert "9 recordings make its history" in (tmp_path / "out" / "watch.html").read_text()


def test_recordings_of_one_stem_have_names_of_their_own(place: Path, tmp_path: Path) -> None:
    """A listed one, one that came before, and two at once."""
    out = tmp_path / "out"
    out.mkdir()
    watch = Watch(load_station(place), out, 5, modes_in)
    record(place, "a", 2)
    looked(watch, out)
    for number, name in enumerate(("first.mat", "a.mat", "b.mat", "b.csv")):
        (place / name).write_bytes(b"")
        os.utime(place / name, (time.time() - 50 + number,) * 2)
    kept = looked(watch, out)
    assert [own.name for own in kept.observations] == ["first", "a", "first.mat", "a.mat", "b", "b.csv"]
    assert looked(watch, out) == kept


def test_any_failure_of_one_recording_is_a_row(place: Path, tmp_path: Path) -> None:
    def failing(dataset: Dataset) -> tuple[SeenMode, ...]:
        if dataset.recordings[0].name == "odd":
            raise ZeroDivisionError("float division by zero")
        return modes_in(dataset)

    out = tmp_path / "out"
    out.mkdir()
    record(place, "odd", 1, age=30.0)
    record(place, "next", 1, age=20.0)
    kept = looked(Watch(load_station(place), out, 5, failing), out)
    assert [(own.name, own.standing.value) for own in kept.observations[1:]] == [
        ("odd", "not readable"),
        ("next", "history"),
    ]
    assert "(ZeroDivisionError: float division by zero)" in kept.observations[1].words[0]


def test_the_command_looks_once_and_tells_an_alarm_by_its_status(
    place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hybrid.monitoring.watching.modes_of", modes_in)
    usual(place)
    words = ["watch", str(place), "--out", str(tmp_path / "out"), "--once", "--no-diagnose"]
    ran = CliRunner().invoke(app, words)
    assert ran.exit_code == 0, ran.output
    assert "The structure is as usual: 7 recordings make its history." in ran.stdout
    record(place, "changed", 1, age=20.0)
    ran = CliRunner().invoke(app, [*words, "--quiet"])
    assert ran.exit_code == door.ALARM_STATUS
    assert ran.stdout.splitlines() == [str(tmp_path / "out" / "watch.html")]
    assert ran.stderr.startswith("ALARM: changed; see ")
    ran = CliRunner().invoke(app, words)
    assert ran.exit_code == 0  # nothing is new
    assert "from recording changed on" in (tmp_path / "out" / "watch.html").read_text()
    ran = CliRunner().invoke(app, [*words, "--accept"])
    assert ran.exit_code == 0, ran.output
    assert "1 of 5 recordings" in ran.stdout
