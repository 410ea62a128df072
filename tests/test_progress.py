"""Progress bars: shown at a terminal alone, silent where asked for, and with an end."""

import io
import sys

import pytest

from fe_models import progress
from fe_models.built_in.four_dof import four_dof
from fe_models.progress import progress_bar, silent, stage_bar
from fe_models.simulated_recordings import simulate
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.stage_names import STAGE_NAMES


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def shown(monkeypatch: pytest.MonkeyPatch, stream: io.StringIO) -> str:
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(progress, "DELAY", 0.0)
    with progress_bar("work", 3, "piece") as bar:
        bar.update()
        bar.refresh()
    return stream.getvalue()


def test_a_bar_at_a_terminal_has_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "1/3" in shown(monkeypatch, Terminal())


def test_a_bar_of_stages_goes_on_by_stages_alone_and_says_what_is_done(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Terminal()
    monkeypatch.setattr(sys, "stderr", stream)
    with stage_bar(("first", "second", "third")) as begin:
        for what in ("loading", "first", "second", "a fit", "a fit", "third"):
            begin(what)
    lines = [line for line in stream.getvalue().split("\r") if "stages done" in line]
    said = [(line.split(" |")[0].strip(), line.rsplit("| ", 1)[1][:6]) for line in lines]
    assert ("a fit, step 2", "1 of 3") in said
    assert said.index(("first", "0 of 3")) < said.index(("second", "1 of 3")) < said.index(("third", "2 of 3"))


def test_a_diagnosis_goes_through_all_stages_that_its_bar_counts() -> None:
    """Of a chain in which nothing is wrong, so that most stages are soon over; with the search's own words within."""
    heard: list[str] = []
    data = simulate(four_dof(), ["x4", "a1"], motions=3, duration=20.0, seed=1).split(0.7)
    diagnose(data, heard.append)
    assert [what for what in heard if what in STAGE_NAMES] == list(STAGE_NAMES)


def test_a_file_gets_no_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    assert shown(monkeypatch, io.StringIO()) == ""


def test_none_is_shown_where_silence_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    with silent():
        assert shown(monkeypatch, Terminal()) == ""
    assert shown(monkeypatch, Terminal()) != ""
