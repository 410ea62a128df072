"""Blind cases of a chain by one sensor, drawn by chance, which can be measured again with one measurement more.

The truth, its recordings and their noise stay as they are: what is added comes beside them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.blind_cases import BlindConfig
from benchmarks.blind_cases.chain_motion import Chain, Moved, driven, motion_of
from benchmarks.blind_cases.drawing import amount_between
from benchmarks.blind_cases.known_forces import MARGIN, Driving
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.causes import AddedMass, Cause, StiffnessChange, SupportSpring
from fe_models.recordings import Dataset, Load, Recording, Sensor
from fe_models.response import Response
from fe_models.structure import Damping, PointMass, Spring, Structure
from hybrid.diagnosis.next_measurement.measurements import Measurement

COUNT = 6
DESIGN = Structure(
    "chain of six",
    tuple((float(node), 0.0) for node in range(COUNT)),
    tuple(Spring((node,) if node == 1 else (node - 1, node), "x", 100.0) for node in range(1, COUNT + 1)),
    point_masses=tuple(PointMass(node, 1.0) for node in range(1, COUNT + 1)),
    directions=("x",),
    damping=Damping(modal_ratios=(0.01,)),
)
# Three periods of the slowest mode, so noisy that one sensor more is not enough wherever it stands.
CONFIG = BlindConfig(noise=0.2, train=1, test=0, duration=10.0, sampling_rate=20.0)
KINDS = ("stiffness_change", "added_mass", "support_spring")
SIZES = {  # smallest and largest, drawn evenly in the logarithm
    "stiffness_change": (0.1, 0.4),  # of the spring
    "added_mass": (0.1, 0.4),  # kg
    "support_spring": (3.0, 20.0),  # N/m
}
BLOW = 0.4  # s: a little more than a period of the fastest mode
STRUCK_AT = 0.1  # of the recording


@dataclass(frozen=True, eq=False)
class OpenCase:
    """A ``chain`` with a hidden ``cause``, as it is moved from ``starts`` (2, recording, node) and seen by ``sensors``.

    ``seed``: of all that is drawn.
    """

    seed: int
    chain: Chain
    cause: Cause
    starts: FloatArray
    sensors: tuple[Sensor, ...]

    @staticmethod
    def of(seed: int) -> "OpenCase":
        """Return the case of a seed: one accelerometer, anywhere, sees the motion from a random state."""
        rng = np.random.default_rng(seed)
        starts = rng.standard_normal((2, CONFIG.campaign.count, COUNT)) * np.array([1.0, 10.0])[:, None, None]  # m, m/s
        kind = KINDS[seed % len(KINDS)]
        node = int(rng.integers(2, COUNT + 1))  # what the first spring does, a support does
        cause = _cause(kind, node, amount_between(*SIZES[kind], rng, None))
        sensor = _sensor(int(rng.integers(1, COUNT + 1)))
        return OpenCase(seed, Chain(DESIGN, (cause,)), cause, starts, (sensor,))

    def dataset(self, added: Measurement | None = None) -> Dataset:
        """Return the recordings, as they are with what is ``added``."""
        sensors = self.sensors
        if added is not None and added.quantity is not None:
            sensors = (*sensors, _sensor(added.node))
        motion, campaign = self._moved(Moved(self.starts)), CONFIG.campaign
        recordings = [
            Recording(f"r{i + 1:02d}", data[None], "train" if i < campaign.train else "test")
            for i, data in enumerate(self._measured(motion, sensors, motion, 0))
        ]
        if added is not None and added.quantity is None:
            recordings.append(self._excited(added, sensors, motion))
        return Dataset(DESIGN, campaign.sampling_rate, sensors, tuple(recordings))

    def _moved(self, moved: Moved) -> Response:
        return motion_of(self.chain, moved, CONFIG, np.random.default_rng(self.seed))

    def _measured(self, motion: Response, sensors: Sequence[Sensor], usual: Response, first: int) -> FloatArray:
        """Return what ``sensors`` show of a motion (recording, time, sensor), each with its own noise, in proportion to
        what it shows of the ``usual`` motion; ``first``: the number of the first recording.
        """
        channels = []
        for sensor in sensors:
            own = (self.seed, sensor.node, first)
            clean = motion.shown(sensor)
            noise = np.random.default_rng(own).standard_normal(clean.shape)
            channels.append(clean + CONFIG.noise * float(usual.shown(sensor).std()) * noise)
        return np.stack(channels, axis=-1)

    def _excited(self, added: Measurement, sensors: Sequence[Sensor], usual: Response) -> Recording:
        """Return one more recording, after a pull or under a blow of such a size that the chain moves as usual."""
        wanted, row = float(np.sqrt(np.mean(usual.displacement**2))), added.node - 1
        number = CONFIG.campaign.count
        if added.kind == "pull":
            stiffness = linearise(self.chain.structure).stiffness.toarray()
            still = np.linalg.solve(stiffness, np.eye(len(stiffness))[row])
            start = np.stack([still, np.zeros_like(still)])[:, None]
            linear = replace(self, chain=Chain(DESIGN))._moved(Moved(start))
            start *= wanted / float(np.sqrt(np.mean(linear.displacement**2)))
            data = self._measured(self._moved(Moved(start)), sensors, usual, number)
            return Recording("pull", data)
        driving = Driving((Load(added.node, "x", _blow()),))
        linear = driven(DESIGN, linearise(DESIGN), (driving,), CONFIG)
        driving = driving.times(wanted / float(np.sqrt(np.mean(linear.displacement**2))))
        config = replace(CONFIG, excitation="measured")
        motion = motion_of(
            self.chain, Moved(np.zeros_like(self.starts[:, :1]), (driving,)), config, np.random.default_rng(self.seed)
        )
        loads = driving.recorded(CONFIG.campaign.sampling_rate).loads
        data = self._measured(motion, sensors, usual, number)
        return Recording("blow", data, loads=loads, excitation="measured")


def _sensor(node: int) -> Sensor:
    return Sensor(f"a{node}", node, "x", "acceleration", "m/s^2")


def _cause(kind: str, node: int, amount: float) -> StiffnessChange | AddedMass | SupportSpring:
    match kind:
        case "stiffness_change":
            return StiffnessChange((node,), 1 - amount)
        case "added_mass":
            return AddedMass(node, amount)
    return SupportSpring(node, "x", amount)


def _blow() -> FloatArray:
    """Return the course of a blow of unit size, (1 - cos) / 2, with margins."""
    campaign = CONFIG.campaign
    time = (np.arange(campaign.samples + 2 * MARGIN) - MARGIN) / campaign.sampling_rate
    phase = np.clip((time - STRUCK_AT * campaign.duration) / BLOW, 0.0, 1.0)
    return np.asarray((1 - np.cos(2 * np.pi * phase)) / 2)
