"""What a diagnosis identified in recordings is handed on to its page, where it was seen by the same sensors."""

from dataclasses import replace

import numpy as np
import pytest

from hybrid.identification import recording_comparison
from hybrid.identification.identification import identify
from hybrid.identification.recording_comparison import compare_recordings
from hybrid.report.seen import seen_in
from tests.pages import answer_by_modes, chain_dataset
from tests.test_modal_evidence import chain


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many sensors each identification from now on sees."""
    seen = list[int]()

    def counted(motions, *rest, **more):  # type: ignore[no-untyped-def]
        seen.append(motions[0].shape[1])
        return identify(motions, *rest, **more)

    monkeypatch.setattr(recording_comparison, "identify", counted)
    return seen


def test_what_is_known_is_not_identified_again(calls: list[int]) -> None:
    dataset = chain_dataset()
    first = compare_recordings(dataset)
    assert len(calls) == 2
    known = {own.name: own.found for own in first.recordings}
    again = compare_recordings(dataset, known=known)
    assert len(calls) == 2
    for one, other in zip(first.recordings, again.recordings, strict=True):
        np.testing.assert_array_equal(one.identified.frequencies, other.identified.frequencies)
        assert one.chosen == other.chosen


def test_a_page_takes_what_the_diagnosis_identified(calls: list[int]) -> None:
    """The recording for training; that for testing no diagnosis identifies, nor what a held-out sensor shows."""
    dataset = chain_dataset()
    every = replace(dataset, sensors=tuple(replace(sensor, role="measured") for sensor in dataset.sensors))
    found = compare_recordings(every).recordings[0].found
    answer = replace(answer_by_modes(every), identified={"before": found})
    calls.clear()
    seen = seen_in(every, answer)
    assert len(calls) == 1
    assert seen.drawn is not None
    np.testing.assert_array_equal(seen.drawn.recordings[0].found.stabilisation.roots, found.stabilisation.roots)
    fewer = replace(found, modes=replace(found.modes, shapes=found.modes.shapes[:-1]))
    calls.clear()
    seen_in(dataset, replace(answer, identified={"before": fewer}))
    assert calls == [len(chain().nodes), len(chain().nodes)]
