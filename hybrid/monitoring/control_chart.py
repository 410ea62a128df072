"""Whether a recording is as the history is: a control chart of each natural frequency, and one of all together.

With n recordings of the history, mean m and variance S^2 of the logarithm of a frequency, the next one, x, obeys

    (x - m) / sqrt(S^2 (1 + 1/n))  ~  t,  n - 1 degrees of freedom

as long as nothing changes: a prediction interval of Student's t for individual values. S^2 is no less, in any
combination of modes, than what the identification itself says of the frequencies (mean of s^2); a recording that tells
a frequency less well than the history has that much more. All together, p frequencies obey Hotelling's

    T^2 = (x - m)' S^-1 (x - m),    T^2 n (n - p) / (p (n - 1) (n + 1))  ~  F(p, n - p)

(Montgomery, Statistical Quality Control, chapter 11; phase II, individual observations). A temperature that moves
all frequencies the same way lies along a long axis of S and raises no alarm; one frequency that moves alone does.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f, t

from fe_models.arrays import FloatArray
from fe_models.modes import mac
from hybrid.identification.config import CHANGES
from hybrid.identification.pairing import is_telling
from hybrid.identification.suspect_sensors import suspect_sensors
from hybrid.monitoring.config import MONITORING
from hybrid.monitoring.observation import Limits, Observation, SeenMode
from hybrid.monitoring.tracked_modes import TrackedModes, tracked

NO_MODE = "no natural mode is seen in it"


@dataclass(frozen=True)
class Judged:
    """A recording beside the history: ``distance``, T^2 over its limit, None where no mode is seen in all; ``limits``
    of each tracked mode; whether it is an ``alarm``, and in ``words`` what is unusual.
    """

    distance: float | None
    limits: tuple[Limits, ...]
    alarm: bool
    words: tuple[str, ...]


def judged(history: Sequence[Observation], observation: Observation, sensors: Sequence[str] = ()) -> Judged:
    """Return how a recording stands to a history of two recordings or more; ``sensors``: their names.

    The chance of a false alarm is shared equally: half for all frequencies together, half for the single ones.
    """
    modes = tracked(history, MONITORING.min_seen, MONITORING.most_modes)
    seen = modes.of(observation)
    logs, errors = _history_of(modes, history)
    chance = MONITORING.false_alarms / 2
    limits = tuple(
        _limits(number, logs[:, number], errors[:, number], own, chance / max(1, len(seen)))
        for number, own in enumerate(seen)
    )
    outside = [own for own in limits if own.found is not None and not own.low <= own.found <= own.high]
    energy, least = _energy_of(modes, history)
    distance = _distance(logs, errors, seen, energy, chance)
    words = [_moved(own) for own in outside]
    if distance is not None and distance > 1 and not outside:
        moved = max((own for own in limits if own.found is not None), key=lambda own: abs(_change(own)))
        words.append(f"frequencies do not go together as usual; most: {_moved(moved)}")
    whole = [number for number in range(len(seen)) if (modes.numbers[:, number] >= 0).all()]
    lost = [number for number in whole if seen[number] is None]
    strong = [number for number in lost if least[number] >= MONITORING.strong_share]
    words += [_lost(number, modes, least[number]) for number in lost] if observation.modes else [NO_MODE]
    words += _in_their_place(modes, seen, observation, sensors) if lost else []
    gone = not observation.modes or bool(strong) or len(lost) > MONITORING.most_lost * len(whole)
    return Judged(distance, limits, bool(outside) or gone or (distance or 0.0) > 1, tuple(words))


def _history_of(modes: TrackedModes, history: Sequence[Observation]) -> tuple[FloatArray, FloatArray]:
    """Return logarithms of frequencies and their standard deviations, (recording, mode); NaN of what is not seen."""
    shape = modes.numbers.shape
    logs, errors = np.full(shape, np.nan), np.full(shape, np.nan)
    for k, mode in np.argwhere(modes.numbers >= 0):
        logs[k, mode], errors[k, mode] = _log_of(history[k].modes[modes.numbers[k, mode]])
    return logs, errors


def _log_of(mode: SeenMode) -> tuple[float, float]:
    return float(np.log(mode.frequency)), max(mode.frequency_error / mode.frequency, CHANGES.least_error)


def _energy_of(modes: TrackedModes, history: Sequence[Observation]) -> tuple[FloatArray, FloatArray]:
    """Return the mean and the least energy, (mode,) each, of each tracked mode where it is seen."""
    mean, least = np.zeros(len(modes.frequencies)), np.zeros(len(modes.frequencies))
    for mode in range(len(mean)):
        own = [history[k].modes[n].energy for k, n in enumerate(modes.numbers[:, mode]) if n >= 0]
        mean[mode], least[mode] = np.mean(own), np.min(own)
    return mean, least


def _limits(number: int, logs: FloatArray, errors: FloatArray, seen: SeenMode | None, chance: float) -> Limits:
    """Return the limits of one frequency, for so much ``chance`` of a false alarm."""
    known = np.isfinite(logs)
    own, count = logs[known], int(known.sum())
    floor = float(np.mean(errors[known] ** 2))
    log, error = _log_of(seen) if seen is not None else (np.nan, 0.0)
    variance = max(float(own.var(ddof=1)) if count > 1 else 0.0, floor) * (1 + 1 / count) + max(0.0, error**2 - floor)
    half = float(t.isf(chance / 2, max(1, count - 1))) * np.sqrt(variance)
    low, centre, high = np.exp(own.mean() + np.array([-half, 0.0, half])).tolist()
    return Limits(number, low, centre, high, None if seen is None else float(np.exp(log)))


def _distance(
    logs: FloatArray, errors: FloatArray, seen: Sequence[SeenMode | None], energy: FloatArray, chance: float
) -> float | None:
    """Return T^2 over its limit, of the strongest modes that all recordings show: half as many as these at most."""
    whole = [number for number, own in enumerate(seen) if own is not None and np.isfinite(logs[:, number]).all()]
    count = len(logs)
    used = sorted(whole, key=lambda number: -energy[number])[: (count - 1) // 2]
    if not used:
        return None
    now = np.array([_log_of(own) for own in (seen[number] for number in used) if own is not None])
    floor = np.mean(errors[:, used] ** 2, axis=0)
    scatter = _at_least(np.atleast_2d(np.cov(logs[:, used], rowvar=False)), floor)
    scatter[np.diag_indices(len(used))] += np.maximum(0.0, now[:, 1] ** 2 - floor)
    apart = now[:, 0] - logs[:, used].mean(axis=0)
    square = float(apart @ np.linalg.solve(scatter, apart))
    modes = len(used)
    limit = float(f.isf(chance, modes, count - modes)) * modes * (count - 1) * (count + 1) / (count * (count - modes))
    return square / limit


def _at_least(scatter: FloatArray, floor: FloatArray) -> FloatArray:
    """Return a covariance (mode, mode) in which no combination of modes scatters less than by the variances ``floor``
    (mode,) alone.
    """
    size = np.sqrt(floor)
    values, vectors = np.linalg.eigh(scatter / np.outer(size, size))
    return np.asarray((vectors * np.maximum(values, 1.0)) @ vectors.T * np.outer(size, size))


def _change(own: Limits) -> float:
    return 0.0 if own.found is None else own.found / own.centre - 1


def _lost(number: int, modes: TrackedModes, least: float) -> str:
    strong = f", though it had at least {least:.0%} of the energy in every recording of the history"
    told = strong if least >= MONITORING.strong_share else ""
    return f"mode {number + 1} ({modes.frequencies[number]:.4g} Hz) is not seen{told}"


def _in_their_place(
    modes: TrackedModes, seen: Sequence[SeenMode | None], observation: Observation, sensors: Sequence[str]
) -> list[str]:
    """Return what a recording shows instead of modes that it lacks, where that speaks of how it was measured."""
    words = list[str]()
    if not observation.modes:
        return words
    factor = _common_factor(modes, seen, observation)
    if factor is not None:
        words.append(
            f"all frequencies are {factor:.3g} times the usual, with the same shapes: is its sampling rate right?"
        )
    suspect = suspect_sensors(modes.frequencies, modes.shapes, observation.frequencies, observation.shapes)
    if suspect is not None:
        names = sensors or [str(number + 1) for number in range(len(modes.shapes))]
        words.append(suspect.words(names, "the usual"))
    return words


def _common_factor(modes: TrackedModes, seen: Sequence[SeenMode | None], observation: Observation) -> float | None:
    """Return by which factor all frequencies differ from the usual where shapes are the same; None where none does."""
    if any(own is not None for own in seen) or len(seen) < 2:
        return None
    criterion = np.atleast_2d(mac(modes.shapes, observation.shapes))
    alike = np.argmax(criterion, axis=1)
    best = criterion[np.arange(len(seen)), alike]
    if best.min() < CHANGES.alone_mac or not is_telling(best, len(modes.shapes)).all():
        return None
    factors = observation.frequencies[alike] / modes.frequencies
    return float(np.median(factors)) if np.ptp(factors) < MONITORING.same_factor * factors.min() else None


def _moved(own: Limits) -> str:
    return (
        f"mode {own.mode + 1}: {own.found:.4g} Hz, {100 * _change(own):+.2g} % off the usual {own.centre:.4g} Hz"
        f" (limits {own.low:.4g} to {own.high:.4g} Hz)"
    )
