"""Whether recordings can be used: sensors that the model has, and data that are finite, alive and rightly sampled."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from math import inf, isinf, pi

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.directions import components, direction_words
from fe_models.dof_map import DofMap
from fe_models.errors import noting
from fe_models.recordings import Quantity, Sensor
from fe_models.spectra import line_frequencies, power_spectrum

MIN_SAMPLES = 32
"""Six samples in the first fifth, from which initial states are found, is the least that distinguishes two modes."""

LOWEST_RATE, HIGHEST_RATE = 1e-6, 1e9  # Hz: a sample in eleven days, and a nanosecond apart
SMALLEST_SIGNAL, LARGEST_SIGNAL = 1e-15, 1e15
"""Sizes of a channel's largest sample, in SI units or normalised, whose squares single precision holds."""

READS_ZERO = "the sensor would read zero"  # at a place that a support holds

DEAD_REMEDY = "leave the sensor, or the recording, out of the dataset (a diagnosis does so itself)"

FLAT_TOLERANCE = 1e-12  # of a channel's largest value: only rounding moves it
TRANSITION_RATIO = 1.1
MAX_ENERGY_SHARE = 0.1
"""A fourth-order Butterworth low-pass leaves 6 % of white noise above `TRANSITION_RATIO` times its corner frequency."""

UNITS: dict[tuple[Quantity, bool], str] = {
    ("displacement", False): "m",
    ("velocity", False): "m/s",
    ("acceleration", False): "m/s^2",
    ("displacement", True): "rad",
    ("velocity", True): "rad/s",
    ("acceleration", True): "rad/s^2",
}
"""SI unit by quantity and whether the direction is a rotation; "1" marks a normalised channel of any quantity."""

STANDARD_ACCELERATION = 9.80665  # m/s^2: what 1 g of an accelerometer is
UNITS_BESIDE: dict[tuple[Quantity, bool], dict[str, float]] = {
    ("displacement", False): {"mm": 1e-3},
    ("velocity", False): {"mm/s": 1e-3},
    ("acceleration", False): {"g": STANDARD_ACCELERATION, "mm/s^2": 1e-3},
    ("displacement", True): {"deg": pi / 180},
}
"""Units of dataset files beside SI, each with what one of it is in SI, to which recordings are brought when read."""


def to_si(sensor: Sensor) -> tuple[Sensor, float]:
    """Return the sensor with its unit in SI, and the factor that brings its recordings there."""
    place = sensor.quantity, sensor.turns
    factor = UNITS_BESIDE.get(place, {}).get(sensor.unit)
    return (sensor, 1.0) if factor is None else (replace(sensor, unit=UNITS[place]), factor)


def check_sensor(sensor: Sensor, dofs: DofMap | None, node_count: int) -> list[str]:
    """Return faults of a sensor's unit and, where the model could be read (``dofs``), of its place."""
    faults = list[str]()
    place = sensor.quantity, sensor.turns
    expected = UNITS[place]
    if sensor.unit not in (expected, "1"):
        kind = f"{sensor.quantity} in {direction_words(sensor.direction)}"
        others = "".join(f', "{unit}"' for unit in UNITS_BESIDE.get(place, {}))
        beside = f"; files may have{others[1:]}" if others else ""
        faults.append(
            f'unit {sensor.unit!r} does not fit {kind}; expected "{expected}" (SI), or "1" if normalised{beside}'
        )
    if dofs is not None:
        parts = noting(faults, "", components, sensor.direction) or {}
        found = [check_place(sensor.node, axis, dofs, node_count, READS_ZERO) for axis in parts]
        if all(found):  # a support may well hold one of two components
            faults.extend(dict.fromkeys(fault for each in found for fault in each))
    return faults


def check_place(node: int, direction: str, dofs: DofMap, node_count: int, if_held: str) -> list[str]:
    """Return a fault where the model has no such degree of freedom, or a support holds it."""
    if not 1 <= node <= node_count:
        return [f"node {node} does not exist; the model's nodes are 1 to {node_count}"]
    rows = np.flatnonzero((dofs.node == node) & (dofs.direction == direction))
    if len(rows) == 0:
        have = ", ".join(dofs.direction[dofs.node == node].tolist()) or "nothing"
        return [f"node {node} cannot move in direction {direction!r} of this model; it has {have}"]
    if not dofs.moves[rows[0]]:
        return [f"node {node} is held in {direction} by a support; {if_held}"]
    return []


def check_sensors(sensors: list[Sensor]) -> list[str]:
    """Return faults of the sensors as a set: repeated names, none measured."""
    times = Counter(sensor.name for sensor in sensors)
    faults = [f"sensors: name {name!r} is used {count} times" for name, count in times.items() if count > 1]
    if all(sensor.role != "measured" for sensor in sensors):
        faults.append('sensors: none has the role "measured"; at least one must be fitted')
    return faults


def check_rates(sampling_rate: float, lowpass: float | None) -> list[str]:
    """Return faults of the two frequencies (Hz)."""
    faults = [] if sampling_rate > 0 else [f"sampling_rate = {sampling_rate:g} Hz; must be positive"]
    if sampling_rate > 0 and not (LOWEST_RATE <= sampling_rate <= HIGHEST_RATE or isinf(sampling_rate)):
        faults.append(f"sampling_rate = {sampling_rate:g} Hz; expected {LOWEST_RATE:g} to {HIGHEST_RATE:g} Hz")
    if lowpass is not None and not 0 < lowpass < inf:
        faults.append(f"lowpass = {lowpass:g} Hz; must be positive, or left out")
    elif lowpass is not None and sampling_rate > 0 and lowpass >= sampling_rate / 2:
        limit = f"half the sampling_rate, {sampling_rate / 2:g} Hz"
        faults.append(f"lowpass = {lowpass:g} Hz is not below {limit}: a wrong sampling rate for its low-pass")
    return faults


def size_faults(values: FloatArray, names: Sequence[str]) -> list[str]:
    """Return a fault for each column of ``values`` (..., column) that is too large to compute with, and one where all
    are too small; a single small one may be nothing but rounding.
    """
    if not values.size:
        return []
    sizes = np.where(np.isfinite(values), abs(values), 0.0).reshape(-1, values.shape[-1])
    places = np.argmax(sizes, axis=0)
    largest = sizes[places, np.arange(len(names))]
    wrong = np.flatnonzero(largest > LARGEST_SIGNAL)
    if 0 < largest.max() < SMALLEST_SIGNAL:
        wrong = np.array([np.argmax(largest)])
    return [
        f"{names[column]}: its largest value is {largest[column]:g} (number {places[column] + 1}); expected"
        f" {SMALLEST_SIGNAL:g} to {LARGEST_SIGNAL:g} in SI units: a wrong unit or factor, or a broken sample?"
        for column in wrong.tolist()
    ]


def check_data(
    data: FloatArray,
    sensors: Sequence[str],
    sampling_rate: float | None,
    lowpass: float | None,
    dead_channels: bool = False,
) -> list[str]:
    """Return faults of one recording (realisation, time, sensor); the rates (Hz) are None where they have faults.

    ``dead_channels``: whether a channel that never changes is no fault.
    """
    realisations, samples, _ = data.shape
    if realisations == 0:
        return ["holds no recording at all"]
    if samples < MIN_SAMPLES:
        return [f"only {samples} samples; at least {MIN_SAMPLES} are needed"]
    faults = []
    for index, name in enumerate(sensors):
        channel = data[:, :, index]  # (realisation, time)
        bad = np.argwhere(~np.isfinite(channel))
        flat = np.flatnonzero(np.ptp(channel, axis=1) <= FLAT_TOLERANCE * abs(channel).max(axis=1))
        if len(bad):
            which = _of_realisation(bad[0, 0], realisations)
            faults.append(
                f"channel {name!r}: {len(bad)} samples are infinite, the first is number {bad[0, 1] + 1}{which}"
            )
        elif len(flat):
            which = _of_realisation(flat[0], realisations)
            if not dead_channels:
                faults.append(
                    f"channel {name!r} is constant ({channel[flat[0], 0]:g}){which}: a dead sensor? {DEAD_REMEDY}"
                )
        elif lowpass is not None and sampling_rate is not None:
            faults.extend(_lowpass_faults(channel, name, sampling_rate, lowpass))
    return faults


def energy_above(channel: FloatArray, sampling_rate: float, frequency: float) -> float:
    """Return the share of a channel's energy above ``frequency`` (Hz), its mean left out; channel (..., time).

    Of its spectrum as it is and under a Hann window, whichever has less there: the one leaks upwards where a motion is
    cut off, the other hides the beginning, where a free decay has its energy.
    """
    samples = channel.shape[-1]
    above = line_frequencies(samples, sampling_rate) > frequency
    shares = []
    for window in (np.ones(samples), np.hanning(samples)):
        mean = (channel * window).sum(-1, keepdims=True) / window.sum()
        power = power_spectrum((channel - mean)[..., None], window)[..., 0]  # (..., frequency)
        shares.append(float(power[..., above].sum() / power.sum()))
    return min(shares)


def _lowpass_faults(channel: FloatArray, name: str, sampling_rate: float, lowpass: float) -> list[str]:
    share = energy_above(channel, sampling_rate, TRANSITION_RATIO * lowpass)
    if share <= MAX_ENERGY_SHARE:
        return []
    return [
        f"channel {name!r}: {share:.0%} of its energy lies well above the lowpass of {lowpass:g} Hz "
        f"(at most {MAX_ENERGY_SHARE:.0%} is expected): a wrong sampling rate for its low-pass, a wrong low-pass, "
        "a spike, or nothing but noise"
    ]


def _of_realisation(index: int, realisations: int) -> str:
    return f" (of recording {index + 1} in this array)" if realisations > 1 else ""
