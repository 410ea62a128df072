"""Which sensors keep measured shapes from being those that are expected at the same frequencies.

Each sensor in turn is left out, and each two are put in each other's place. What makes the shapes of all modes agree
far better than chance does is told; by chance shapes at n sensors agree as well or better with the probability

    prod_k P(MAC > MAC_k),   MAC ~ beta(1/2, (n - 1) / 2)   (see `pairing`),

once for each of the suppositions. A sensor that was left out shows, over what the expected shapes have there,

    g = sum_k u_k conj(e_k) / sum_k |e_k|^2,   e_k = c_k phi_k (i w_k)^p,

with c_k the scale of the measured shape u_k over the expected one phi_k at the other sensors, and p = 0. Where another
p fits, the sensor shows another derivative of the displacement than is stated.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.stats import beta

from fe_models.arrays import TINY, ComplexArray, FloatArray
from fe_models.modes import mac
from hybrid.identification.config import COMPARISON, PAIRING, SUSPECT_SENSORS

MODELS = "the model's"  # whose modes are expected, mostly
DERIVATIVES = {
    -2: "as a displacement does that is stated as an acceleration",
    -1: "as a velocity does that is stated as an acceleration, or a displacement stated as a velocity",
    1: "as an acceleration does that is stated as a velocity, or a velocity stated as a displacement",
    2: "as an acceleration does that is stated as a displacement",
}


@dataclass(frozen=True)
class SuspectSensors:
    """The numbers of ``sensors``: one that does not fit, or two in each other's place. ``modes``: numbers of the
    expected modes whose shapes are found without it; ``gain``: what the one shows over what is expected, None where
    that differs from mode to mode, or of two; ``derivative``: how many times more often than stated its signal is
    differentiated.
    """

    sensors: tuple[int, ...]
    modes: tuple[int, ...]
    gain: float | None = None
    derivative: int = 0

    def words(self, names: Sequence[str], whose: str) -> str:
        """Return it in words; ``names`` (sensor,), ``whose``: of what the expected modes are."""
        many = "s" * (len(self.modes) > 1)
        modes = f"mode{many} {', '.join(str(mode + 1) for mode in self.modes)}"
        at = f"at the frequenc{'ies' if many else 'y'} of {whose} {modes}"
        if len(self.sensors) > 1:
            first, second = (names[number] for number in self.sensors)
            return f"shapes {at} would agree with {first} and {second} in each other's place: check cables and names"
        (name,) = (names[number] for number in self.sensors)
        if self.derivative:
            shows = f"it moves {DERIVATIVES[self.derivative]}"
        elif self.gain is None:
            shows = "what it shows does not go with the others"
        elif abs(self.gain) < SUSPECT_SENSORS.least_gain:
            shows = "it hardly shows that they move"
        else:
            shows = f"it shows {self.gain:.2g} times what is expected"
        return f"shapes {at} agree without sensor {name}: {shows}; check its quantity, unit, direction, place and cable"


def suspect_sensors(
    expected: FloatArray, shapes: FloatArray, frequencies: FloatArray, found: FloatArray | ComplexArray
) -> SuspectSensors | None:
    """Return the sensors without which, or the two in whose places, shapes agree; None where nothing tells so.

    ``expected`` (mode,) and ``frequencies`` (other,): natural frequencies, Hz, of modes with ``shapes`` (sensor, mode)
    and ``found`` (sensor, other), of displacements; of real ones no other derivative can be told.
    """
    pairs = _near(expected, frequencies)
    if not pairs:
        return None
    modes, own = (list(numbers) for numbers in zip(*pairs, strict=True))
    phi, u = shapes[:, modes], found[:, own]
    if _mac(phi, u).min() >= COMPARISON.min_mac:
        return None  # there is nothing to explain
    every = list(_suppositions(phi, u))
    chances = [chance for chance, _ in every]
    if not every or min(chances) * len(every) > PAIRING.max_chance:
        return None
    sensors = every[int(np.argmin(chances))][1]
    if len(sensors) > 1:
        return SuspectSensors(sensors, tuple(modes))
    expected_there, shown = _expected(phi, u, sensors[0]), u[sensors[0]]
    right = np.abs(shown - expected_there) <= SUSPECT_SENSORS.most_left * np.abs(expected_there)
    if right.mean() >= SUSPECT_SENSORS.most_right:
        return None  # noise, in modes that it hardly shows
    return SuspectSensors(sensors, tuple(modes), *_gain(shown, expected_there, 2 * np.pi * frequencies[own]))


def _near(expected: FloatArray, frequencies: FloatArray) -> list[tuple[int, int]]:
    """Return the modes and others that are each other's nearest in frequency, and near enough."""
    if not len(expected) or not len(frequencies):
        return []
    apart = np.abs(np.log(frequencies / expected[:, None]))
    near = apart <= -np.log1p(-COMPARISON.max_frequency_difference)
    return [
        (mode, int(own))
        for mode, own in enumerate(np.argmin(apart, axis=1))
        if near[mode, own] and int(np.argmin(apart[:, own])) == mode
    ]


def _suppositions(phi: FloatArray, u: FloatArray | ComplexArray) -> Iterator[tuple[float, tuple[int, ...]]]:
    """Yield the chance of each supposition under which all shapes agree, with its sensors."""
    count = len(phi)
    for number in range(count):
        yield from _chance(np.delete(phi, number, axis=0), np.delete(u, number, axis=0), (number,))
    for first, second in combinations(range(count), 2):
        order = np.arange(count)
        order[[first, second]] = second, first
        yield from _chance(phi, u[order], (first, second))


def _chance(
    phi: FloatArray, u: FloatArray | ComplexArray, sensors: tuple[int, ...]
) -> Iterator[tuple[float, tuple[int, ...]]]:
    criterion = _mac(phi, u)
    if len(phi) > 1 and criterion.min() >= COMPARISON.min_mac:
        yield float(np.prod(beta.sf(criterion, 0.5, (len(phi) - 1) / 2))), sensors


def _mac(phi: FloatArray, u: FloatArray | ComplexArray) -> FloatArray:
    """Return the MAC (mode,) of each shape with its own other."""
    return np.diagonal(np.atleast_2d(mac(phi, u)))


def _expected(phi: FloatArray, u: FloatArray | ComplexArray, sensor: int) -> FloatArray | ComplexArray:
    """Return what a sensor would show in each mode, (mode,), by what the others show."""
    others = np.delete(np.arange(len(phi)), sensor)
    scale = np.sum(u[others] * phi[others], axis=0) / np.maximum(np.sum(phi[others] ** 2, axis=0), TINY)
    return np.asarray(scale * phi[sensor])


def _gain(
    shown: FloatArray | ComplexArray, expected: FloatArray | ComplexArray, omega: FloatArray
) -> tuple[float | None, int]:
    """Return what is ``shown`` over what is ``expected`` (mode,), None where modes differ in it, and the derivative."""
    size, usual = float(np.linalg.norm(shown)), float(np.linalg.norm(expected))
    gain, left = _fit(shown, expected)
    if left <= SUSPECT_SENSORS.most_left * (size if size > SUSPECT_SENSORS.least_gain * usual else usual):
        return gain, 0
    if np.iscomplexobj(shown):
        fits = {power: _fit(shown, expected * (1j * omega) ** power) for power in DERIVATIVES}
        best = min(fits, key=lambda power: fits[power][1])
        if fits[best][0] > 0 and fits[best][1] <= SUSPECT_SENSORS.most_left * size:
            return None, best
    return (gain, 0) if size <= SUSPECT_SENSORS.least_gain * usual else (None, 0)


def _fit(shown: FloatArray | ComplexArray, expected: FloatArray | ComplexArray) -> tuple[float, float]:
    """Return the real factor of what is ``expected`` (mode,) that is nearest to what is ``shown``, and what is left."""
    gain = float(np.real(np.vdot(expected, shown)) / max(float(np.vdot(expected, expected).real), TINY))
    return gain, float(np.linalg.norm(shown - gain * expected))
