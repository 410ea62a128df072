"""What is recorded of that which drives a chain: random forces, sweeps, knocks, and earthquakes.

Each course goes on for `MARGIN` samples before and after the recording, so that what a late instrument records is that
of the same course.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import butter, chirp, sosfiltfilt
from scipy.signal.windows import tukey

from benchmarks.blind_cases.case import BlindConfig
from fe_models.arrays import FloatArray
from fe_models.base_motion import BaseMotion
from fe_models.causes import Cause, LoadDelay, LoadGain
from fe_models.interpolant import interpolant
from fe_models.recordings import Load

MARGIN = 10  # samples
HIGHEST = (0.5, 1.5)  # Hz, of random forces; the chain's modes end at 0.34 Hz
SWEPT = (0.02, 0.5)  # Hz, of sweeps: past all modes
LASTS = (1.0, 2.5)  # s, of a knock: less than a period of the fastest mode
KNOCKS = 3  # at most in a recording
GROUND = (1.0, 3.0)  # rad/s: natural frequency of the ground beside the chain's, 0.25 to 2.1
GROUND_RATIO = (0.4, 0.7)  # its damping ratio; 0.6 is usual
GROUND_FLOOR = 0.1  # rad/s: slower than that, no ground shakes
SHAKEN = (0.15, 0.45)  # of an earthquake's duration: until it is strong, and until it dies away
BAND_SHARE = 0.25  # of the sampling rate: nothing is above it
SIZE = 1.0  # m: rms of the displacements that each recording's forces are scaled to, as those of free motion


@dataclass(frozen=True)
class Driving:
    """The ``loads`` and the ``base`` motion of a recording, both with margins."""

    loads: tuple[Load, ...] = ()
    base: tuple[BaseMotion, ...] = ()

    @property
    def all(self) -> tuple[Load | BaseMotion, ...]:
        """Loads, then base motions."""
        return (*self.loads, *self.base)

    def times(self, factor: float) -> "Driving":
        """Return it ``factor`` times as strong."""
        loads = tuple(replace(load, values=factor * load.values) for load in self.loads)
        return Driving(loads, tuple(replace(motion, values=factor * motion.values) for motion in self.base))

    def recorded(self, sampling_rate: float, faults: Sequence[Cause] = ()) -> "Driving":
        """Return what is recorded of it, without margins, with each of the ``faults`` that is one of a load."""
        loads = tuple(_recorded(load, faults, sampling_rate) for load in self.loads)
        return Driving(loads, tuple(motion.part(MARGIN, len(motion.values) - MARGIN) for motion in self.base))


def _recorded(load: Load, faults: Sequence[Cause], sampling_rate: float) -> Load:
    gain, late = 1.0, 0.0
    for fault in faults:
        if isinstance(fault, LoadGain) and fault.load == (load.node, load.direction):
            gain *= fault.factor
        if isinstance(fault, LoadDelay) and fault.load == (load.node, load.direction):
            late += fault.delay
    at = np.arange(MARGIN, len(load.values) - MARGIN) - late * sampling_rate
    return replace(load, values=gain * interpolant(load.values)(at))


def drawn_driving(config: BlindConfig, nodes: int, rng: np.random.Generator) -> tuple[Driving, ...]:
    """Return what drives each recording of a chain with so many ``nodes``, all of about one size.

    Under "measured" forces a shaker and a hammer stand at a node each.
    """
    if config.excitation == "base":
        return tuple(Driving(base=(BaseMotion("x", _earthquake(config, rng)),)) for _ in range(config.campaign.count))
    shaker, hammer = (int(node) for node in rng.choice(nodes, 2, replace=False) + 1)
    found = []
    for _ in range(config.campaign.count):
        word = str(rng.choice(["random", "sweep", "knocks", "both"]))
        loads = []
        if word != "knocks":
            course = _sweep(config, rng) if word == "sweep" else _random(config, rng)
            loads.append(Load(shaker, "x", course))
        if word in ("knocks", "both"):
            loads.append(Load(hammer, "x", _knocks(config, rng)))
        found.append(Driving(tuple(loads)))
    return tuple(found)


def _time(config: BlindConfig) -> FloatArray:
    """Return the times of samples with margins, s."""
    return (np.arange(config.campaign.samples + 2 * MARGIN) - MARGIN) / config.campaign.sampling_rate


def _passed(values: FloatArray, highest: float, rate: float) -> FloatArray:
    sections = butter(4, min(highest, BAND_SHARE * rate), fs=rate, output="sos")
    passed = np.asarray(sosfiltfilt(sections, values))
    return passed / passed.std()


def _random(config: BlindConfig, rng: np.random.Generator) -> FloatArray:
    white = rng.standard_normal(len(_time(config)))
    return _passed(white, float(rng.uniform(*HIGHEST)), config.campaign.sampling_rate)


def _sweep(config: BlindConfig, rng: np.random.Generator) -> FloatArray:
    time, (low, high) = _time(config), SWEPT if rng.uniform() < 0.5 else SWEPT[::-1]
    course = chirp(time - time[0], low, time[-1] - time[0], high, method="logarithmic", phi=float(rng.uniform(0, 360)))
    return np.asarray(course * tukey(len(time), 0.1))


def _knocks(config: BlindConfig, rng: np.random.Generator) -> FloatArray:
    """Return a few pulses (1 - cos) / 2, which the samples tell."""
    time, course = _time(config), np.zeros(len(_time(config)))
    for _ in range(int(rng.integers(1, KNOCKS + 1))):
        begins, lasts = rng.uniform(0.0, 0.6) * config.campaign.duration, rng.uniform(*LASTS)
        phase = np.clip((time - begins) / lasts, 0.0, 1.0)
        course += rng.uniform(0.5, 1.0) * (1 - np.cos(2 * np.pi * phase)) / 2
    return course


def _earthquake(config: BlindConfig, rng: np.random.Generator) -> FloatArray:
    """Return white noise through the ground (Kanai and Tajimi, as Clough and Penzien have it) that rises, stays strong
    and dies away (Jennings).
    """
    time, rate = _time(config), config.campaign.sampling_rate
    omega = 2 * np.pi * np.fft.rfftfreq(len(time), 1 / rate)
    ground, ratio = float(np.exp(rng.uniform(*np.log(GROUND)))), float(rng.uniform(*GROUND_RATIO))
    felt = (ground**2 + 2j * ratio * ground * omega) / (ground**2 - omega**2 + 2j * ratio * ground * omega)
    felt *= omega**2 / (GROUND_FLOOR**2 - omega**2 + 2j * ratio * GROUND_FLOOR * omega)
    shaken = np.fft.irfft(felt * np.fft.rfft(rng.standard_normal(len(time))), len(time))
    part = np.clip(time / config.campaign.duration, 0.0, 1.0)
    strong, dies = SHAKEN
    course = np.where(part < strong, (part / strong) ** 2, np.exp(-3.0 * np.maximum(part - dies, 0.0)))
    return _passed(shaken * course, np.inf, rate)


def loads_of(driving: Sequence[Driving]) -> tuple[int, ...]:
    """Return the nodes at which forces were recorded, each once."""
    return tuple(sorted({load.node for item in driving for load in item.loads}))
