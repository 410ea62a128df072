"""Progress bars: shown at a terminal alone, silent where asked for, and with an end."""

import io
import sys

import pytest

from fe_models import progress
from fe_models.progress import progress_bar, silent


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def shown(monkeypatch: pytest.MonkeyPatch, stream: io.StringIO, total: int | None = 3) -> str:
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setattr(progress, "DELAY", 0.0)
    with progress_bar("work", total, "piece") as bar:
        bar.update()
        bar.refresh()
    return stream.getvalue()


def test_a_bar_at_a_terminal_has_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "1/3" in shown(monkeypatch, Terminal())


def test_without_an_end_it_tells_the_time_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "work [00:0" in shown(monkeypatch, Terminal(), None)


def test_a_file_gets_no_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    assert shown(monkeypatch, io.StringIO()) == ""


def test_none_is_shown_where_silence_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    with silent():
        assert shown(monkeypatch, Terminal()) == ""
    assert shown(monkeypatch, Terminal()) != ""
