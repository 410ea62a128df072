"""Windows: which samples they hold, and how long they may be."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.errors import InputError
from fe_models.recordings import Dataset, Recording
from hybrid.config import Config, ModelConfig, TrainingConfig
from hybrid.estimation.windows import columns, cut, cut_all, cut_field, window_length
from tests.hybrid_problems import HELD_OUT, MEASURED, chain_dataset


def numbered(realisations: int, samples: int, name: str = "r") -> Recording:
    """A recording in which every value tells its realisation, sample and sensor: 1000 r + 10 k + s."""
    r, k, s = np.ogrid[:realisations, :samples, :2]
    return Recording(name, 1000.0 * r + 10.0 * k + s)


@pytest.mark.parametrize(
    ("samples", "length", "stride", "starts"), [(10, 4, 3, [0, 3, 6]), (9, 9, 5, [0]), (9, 8, 1, [0, 1])]
)
def test_windows_start_every_stride_samples_as_long_as_they_fit(
    samples: int, length: int, stride: int, starts: list[int]
) -> None:
    recording = numbered(2, samples)
    expected = [recording.data[r, start : start + length] for r in range(2) for start in starts]
    np.testing.assert_array_equal(cut(recording, length, stride), expected)


def test_windows_of_several_recordings_follow_each_other() -> None:
    first, second = numbered(1, 6), numbered(2, 7, "s")
    together = cut_all([first, second], 5, 1)
    np.testing.assert_array_equal(together, np.concatenate([cut(first, 5, 1), cut(second, 5, 1)]))
    assert len(together) == 2 + 2 * 3


def test_a_field_is_cut_where_its_recording_is() -> None:
    """The field is that of the first realisation; windows in which that one's channels are silent are passed over."""
    recording = numbered(2, 12)
    recording.data[0, :5] = 0.0
    field = np.arange(12.0)[:, None] * np.array([1.0, 10.0, 100.0])
    found = cut_field(field, recording, 4, 2)
    assert found[:, 0, 0].tolist() == [2.0, 4.0, 6.0, 8.0]  # the window from 0 is silent, that from 2 not wholly
    np.testing.assert_array_equal(found, [field[start : start + 4] for start in (2, 4, 6, 8)])
    np.testing.assert_array_equal(cut(recording, 4, 2)[:4, 3, 0], 10.0 * found[:, 3, 0])


def test_columns_of_a_role() -> None:
    dataset = chain_dataset(samples=40)
    assert columns(dataset, "measured") == MEASURED
    assert columns(dataset, "held_out") == [HELD_OUT]


def wanting(window: int | None, encoder_samples: int = 10, experts: bool = False) -> Config:
    """A configuration with a window of so many samples, a new one every 20."""
    model = ModelConfig(encoder_samples=encoder_samples, experts=experts)
    return Config(model, TrainingConfig(window=window, stride=20))


def with_lengths(*samples: int) -> Dataset:
    """Training recordings of so many samples, and a test recording as long as the longest."""
    recordings = [numbered(1, length, f"r{number}") for number, length in enumerate(samples)]
    test = replace(numbered(1, max(samples), "test"), role="test")
    return replace(chain_dataset(samples=40), recordings=(*recordings, test))


def test_a_window_is_as_long_as_the_shortest_recording_allows() -> None:
    dataset = chain_dataset(samples=60)
    assert window_length(dataset, wanting(50)) == 50
    assert window_length(dataset, wanting(500)) == 60
    shorter = replace(dataset, recordings=(*dataset.recordings, Recording("brief", np.zeros((1, 45, 5)))))
    assert window_length(shorter, wanting(500)) == 45


@pytest.mark.parametrize(
    ("samples", "experts", "length", "windows"),
    [
        ((5000,), False, 500, 226),  # long ones keep the paper's windows
        ((499, 499), False, 319, 20),
        ((450, 499, 600), False, 399, 20),
        ((450,), False, 225, 12),  # no shorter than half of the recording
        ((60,), False, 40, 2),  # nor than the encoder needs
        ((1000, 1000), False, 500, 52),
        ((1000, 600), True, 300, 36 + 16),  # each expert learns from its own
    ],
)
def test_short_recordings_give_several_windows(
    samples: tuple[int, ...], experts: bool, length: int, windows: int
) -> None:
    dataset = with_lengths(*samples)
    config = wanting(None, experts=experts)
    assert window_length(dataset, config) == length
    assert len(cut_all(dataset.select("train"), length, config.training.stride)) == windows
    assert window_length(dataset, wanting(450)) == min(450, *samples)  # whoever says how long gets that


def test_many_realisations_are_many_windows() -> None:
    many = replace(chain_dataset(samples=40), recordings=(numbered(20, 501),))
    assert window_length(many, wanting(None)) == 500


def test_recordings_that_are_too_short_are_named() -> None:
    dataset = chain_dataset(samples=39)
    for window in (500, None):
        with pytest.raises(InputError, match=r"recording 'one' has 39 samples: a window needs at least 40"):
            window_length(dataset, wanting(window))


def test_windows_hold_more_than_the_encoder_sees() -> None:
    with pytest.raises(InputError, match="a window of 40 samples is too short: at least 200"):
        window_length(chain_dataset(samples=400), wanting(40, encoder_samples=50))
