"""Control charts: limits of what is usual, false alarms, modes that move far or are lost."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from hybrid.monitoring import control_chart
from hybrid.monitoring.config import MONITORING
from hybrid.monitoring.control_chart import judged
from hybrid.monitoring.observation import Observation, SeenMode, Standing
from hybrid.monitoring.tracked_modes import tracked

FREQUENCIES = np.array([2.0, 6.0, 11.0])  # Hz
SHAPES = np.linalg.qr(np.random.default_rng(0).standard_normal((4, 3)))[0]  # orthogonal: no mode taken for another
ERROR = 1e-4  # relative, of each identified frequency


def observed(
    name: str,
    frequencies: FloatArray,
    standing: Standing = Standing.HISTORY,
    error: float = ERROR,
    energy: tuple[float, float, float] = (0.3, 0.3, 0.3),
) -> Observation:
    modes = tuple(
        SeenMode(float(f), float(error * f), 0.01, 0.001, energy[k], tuple(SHAPES[:, k]))
        for k, f in enumerate(frequencies)
        if np.isfinite(f)
    )
    return Observation(name, f"/data/{name}.csv", 0, 1, standing, modes)


def history(rng: np.random.Generator, count: int, scatter: float = 1e-3, together: float = 0.0) -> list[Observation]:
    """Recordings whose frequencies scatter, each for itself and all ``together``, relative to their values."""
    moves = scatter * rng.standard_normal((count, 3)) + together * rng.standard_normal((count, 1))
    return [observed(f"r{k}", FREQUENCIES * np.exp(move)) for k, move in enumerate(moves)]


def test_false_alarms_are_as_rare_as_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 500 structures that did not change, each with a history of eight, 5 % are to raise an alarm.

    Bonferroni's and the two charts' shares overlap, so that fewer do: 3 to 5 %, with a standard deviation of 1 %.
    """
    monkeypatch.setattr(control_chart, "MONITORING", replace(MONITORING, false_alarms=0.05))
    rng = np.random.default_rng(1)
    alarms = sum(judged(own[:-1], own[-1]).alarm for own in (history(rng, 9) for _ in range(500)))
    assert 0.01 < alarms / 500 < 0.08


def test_a_frequency_that_moves_is_named_with_its_limits() -> None:
    rng = np.random.default_rng(2)
    found = judged(history(rng, 10), observed("now", FREQUENCIES * [1, 0.97, 1]))
    assert found.alarm
    assert found.distance is not None and found.distance > 1
    assert found.words[0].startswith("mode 2: 5.82 Hz, -3")
    limits = found.limits[1]
    assert limits.low < limits.centre < limits.high
    assert limits.high / limits.low - 1 < 0.02  # 2 x 5.3 x 1e-3: t of 9 degrees of freedom, of a chance of 4.5e-4
    assert limits.found == pytest.approx(5.82)


def test_what_moves_together_as_usual_is_no_alarm_and_one_alone_is() -> None:
    """A temperature moves all frequencies by a per cent; one that moves by as much alone is within its own limits."""
    rng = np.random.default_rng(3)
    usual = history(rng, 20, scatter=1e-4, together=0.01)
    warm = judged(usual, observed("warm", FREQUENCIES * 1.015))
    assert not warm.alarm, warm.words
    alone = judged(usual, observed("alone", FREQUENCIES * [1.0, 1.01, 1.0]))
    assert alone.alarm
    assert all(own.found is not None and own.low <= own.found <= own.high for own in alone.limits)
    assert alone.words[0].startswith("frequencies do not go together as usual; most: mode 2: 6.06 Hz")


def test_a_recording_that_tells_less_has_wider_limits() -> None:
    usual = history(np.random.default_rng(4), 8)
    moved = FREQUENCIES * [1.02, 1, 1]
    assert judged(usual, observed("long", moved)).alarm
    assert not judged(usual, observed("short", moved, error=0.02)).alarm


def test_exact_data_have_limits_all_the_same() -> None:
    usual = [observed(f"r{k}", FREQUENCIES) for k in range(6)]
    assert not judged(usual, observed("now", FREQUENCIES)).alarm
    assert judged(usual, observed("now", FREQUENCIES * 1.01)).alarm


def test_what_the_identification_cannot_tell_is_no_change_however_alike_the_history() -> None:
    """Frequencies that went together exactly, and a recording that strays from that by 1.5 standard deviations."""
    usual = history(np.random.default_rng(6), 12, scatter=0.0, together=0.01)
    assert not judged(usual, observed("now", FREQUENCIES * [1, 1 + 1.5 * ERROR, 1])).alarm


def test_weak_modes_that_are_gone_are_told_and_most_of_them_are_an_alarm() -> None:
    weak = (0.9, 0.009, 0.009)
    usual = [observed(f"r{k}", FREQUENCIES * (1 + 1e-3 * k), energy=weak) for k in range(8)]
    one = judged(usual, observed("one", FREQUENCIES * [1, np.nan, 1]))
    assert not one.alarm
    assert one.words == ("mode 2 (6.021 Hz) is not seen",)
    two = judged(usual, observed("two", FREQUENCIES * [1, np.nan, np.nan]))
    assert two.alarm and len(two.words) == 2


def test_a_strong_mode_that_is_gone_is_an_alarm() -> None:
    found = judged(history(np.random.default_rng(5), 8), observed("one", FREQUENCIES * [1, np.nan, 1]))
    assert found.alarm
    (words,) = found.words
    assert words.endswith("is not seen, though it had at least 30% of the energy in every recording of the history")


@pytest.mark.parametrize("factor", [0.65, 0.8, 1.4])
def test_a_frequency_that_moves_far_is_known_by_its_shape(factor: float) -> None:
    """Of a mode of 2 Hz; the gate is a factor of exp(0.5) = 1.65."""
    found = judged(history(np.random.default_rng(7), 8), observed("now", FREQUENCIES * [factor, 1, 1]))
    assert found.alarm
    assert found.words[0].startswith(f"mode 1: {2 * factor:.4g} Hz, {100 * (factor - 1):+.0f} % off the usual")


def test_one_sensor_tells_no_mode_by_its_shape() -> None:
    """All shapes are alike there: a mode of 3 Hz is no 2 Hz that moved, which is told as lost."""
    usual = [one_sensor(observed(f"r{k}", FREQUENCIES * (1 + 1e-3 * k))) for k in range(8)]
    found = judged(usual, one_sensor(observed("now", FREQUENCIES * [1.5, 1, 1])))
    assert found.alarm
    assert found.words[0].startswith("mode 1 (2.007 Hz) is not seen")


def test_a_wrong_sampling_rate_is_asked_about() -> None:
    found = judged(history(np.random.default_rng(7), 8), observed("now", FREQUENCIES * 2))
    assert found.alarm
    assert found.words[-1] == "all frequencies are 2 times the usual, with the same shapes: is its sampling rate right?"
    apart = judged(history(np.random.default_rng(7), 8), observed("now", FREQUENCIES * [2.0, 2.2, 2.4]))
    assert not any("sampling rate" in words for words in apart.words)


def test_a_sensor_that_was_turned_round_is_named() -> None:
    rng = np.random.default_rng(8)
    shapes = rng.standard_normal((3, 5))

    def shown(own: Observation, signs: FloatArray) -> Observation:
        pairs = zip(own.modes, shapes, strict=True)
        return replace(own, modes=tuple(replace(mode, shape=tuple((shape * signs).tolist())) for mode, shape in pairs))

    right = np.ones(5)
    turned = np.where(np.arange(5) == 3, -1.0, 1.0)
    usual = [shown(own, right) for own in history(rng, 8)]
    found = judged(usual, shown(observed("now", FREQUENCIES), turned), ["a", "b", "c", "d", "e"])
    assert found.alarm
    assert "agree without sensor d: it shows -1 times what is expected" in found.words[-1]


def one_sensor(own: Observation) -> Observation:
    return replace(own, modes=tuple(replace(mode, shape=(1.0,)) for mode in own.modes))


def test_modes_are_followed_by_shape_where_frequencies_cross() -> None:
    first, second = observed("a", np.array([2.0, 2.05, 11.0])), observed("b", np.array([2.06, 2.04, 11.0]))
    modes = tracked([first, second], 0.8, 12)
    assert [second.modes[n].shape for n in modes.numbers[1]] == [first.modes[n].shape for n in modes.numbers[0]]
