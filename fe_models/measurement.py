"""What sensors make of a motion: one channel each, low-pass filtered, sampled, and with noise.

Real recordings have passed an anti-aliasing filter, signal and noise alike: those of the laboratory bridge are sampled
at 100 Hz behind a low-pass of 30 Hz.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.signal import butter, sosfiltfilt

from fe_models.arrays import FloatArray
from fe_models.errors import raise_faults
from fe_models.files.recording_checks import check_rates, check_sensor
from fe_models.recordings import Sensor
from fe_models.response import Response

FILTER_ORDER = 4  # Butterworth, run forwards and backwards: order 8 in effect, and no phase shift


def measure(
    response: Response,
    sensors: tuple[Sensor, ...],
    sampling_rate: float,
    rng: np.random.Generator,
    lowpass: float | None = None,
    noise: float | Mapping[str, float] = 0.0,
    start: float = 0.0,
) -> FloatArray:
    """Return what the ``sensors`` record of one motion from ``start`` (s) on, (time, sensor).

    ``sampling_rate`` (Hz) must divide that of the response. ``lowpass`` (Hz) acts on the motion before it is sampled,
    so that nothing is folded down from above half the sampling rate, and on the noise. ``noise`` is the standard
    deviation of the noise in the recording over that of each channel without it; or, of the sensors of each unit
    ("m/s^2"), the standard deviation itself in that unit. `InputError` with all faults.
    """
    raise_faults(_faults(response, sensors, sampling_rate, lowpass, noise, start))
    every = round(response.sampling_rate / sampling_rate)
    motion = np.stack([response.shown(sensor) for sensor in sensors], axis=-1)  # (time, sensor)
    signal = lowpassed(motion, response.sampling_rate, lowpass)[::every][round(start * sampling_rate) :]
    white = rng.standard_normal(signal.shape)
    disturbance = lowpassed(white, sampling_rate, lowpass)
    std = np.array([noise[s.unit] for s in sensors]) if isinstance(noise, Mapping) else noise * signal.std(axis=0)
    disturbance *= std / disturbance.std(axis=0)
    return np.asarray(signal + disturbance)


def lowpassed(channels: FloatArray, sampling_rate: float, lowpass: float | None) -> FloatArray:
    """Return channels (time, sensor) without what lies above ``lowpass`` (Hz), and without delay."""
    if lowpass is None:
        return channels
    sections = butter(FILTER_ORDER, lowpass, fs=sampling_rate, output="sos")
    mirrored = min(3 * (2 * len(sections) + 1), len(channels) - 1)  # beyond either end: as many as there are
    return np.asarray(sosfiltfilt(sections, channels, axis=0, padlen=mirrored))


def noise_faults(noise: float | Mapping[str, float], sensors: Sequence[Sensor]) -> list[str]:
    """Return what is wrong with a ``noise``: of all channels relative to each, or by unit."""
    if not isinstance(noise, Mapping):
        if 0 <= noise < np.inf:
            return []
        return [f"noise = {noise}; must be 0 or more (0.03 is 3 % of each channel's standard deviation)"]
    faults = [f"noise = {value} {unit}; must be 0 or more" for unit, value in noise.items() if not 0 <= value < np.inf]
    units = dict.fromkeys(sensor.unit for sensor in sensors)
    faults += [
        f"noise in {unit}: no sensor has that unit; they have {', '.join(units)}" for unit in noise if unit not in units
    ]
    for unit in units:
        if unit not in noise:
            names = ", ".join(sensor.name for sensor in sensors if sensor.unit == unit)
            faults.append(f"noise of the sensors in {unit} ({names}) is missing: give it, too, such as 0.01 {unit}")
    return faults


def _faults(
    response: Response,
    sensors: tuple[Sensor, ...],
    sampling_rate: float,
    lowpass: float | None,
    noise: float | Mapping[str, float],
    start: float,
) -> list[str]:
    faults = check_rates(sampling_rate, lowpass)
    nodes = int(response.dofs.node.max())
    for sensor in sensors:
        faults += [f"sensor {sensor.name!r}: {fault}" for fault in check_sensor(sensor, response.dofs, nodes)]
    if not sensors:
        faults.append("there is no sensor")
    if response.displacement.ndim != 2:
        faults.append(
            f"the response has shape {response.displacement.shape}; measure one motion, (time, dof), at a time"
        )
    faults += noise_faults(noise, sensors)
    end = len(response.time) / response.sampling_rate
    if not 0 <= start < end:
        faults.append(f"start = {start:g} s; must be 0 or more and before the response ends, after {end:g} s")
    ratio = response.sampling_rate / sampling_rate if sampling_rate > 0 else 1.0
    if abs(ratio - round(ratio)) > 1e-6 or round(ratio) < 1:
        faults.append(
            f"sampling_rate = {sampling_rate:g} Hz does not divide that of the response, {response.sampling_rate:g} Hz"
        )
    elif 0 <= start < end and -(-len(response.time) // round(ratio)) - round(start * sampling_rate) < 2:
        faults.append(
            f"the response lasts {end - start:g} s, one sample at {sampling_rate:g} Hz; a recording has two or more:"
            " let it last longer"
        )
    return faults
