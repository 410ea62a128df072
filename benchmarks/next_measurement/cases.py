"""Blind cases of the chain by few sensors, drawn by chance, which can be measured again with one measurement more.

The truth, its recordings and their noise stay as they are: what is added comes beside them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.blind_cases import BlindConfig
from benchmarks.blind_cases.chain import draw_cause
from benchmarks.blind_cases.chain_motion import Chain, Moved, driven, motion_of
from benchmarks.blind_cases.known_forces import MARGIN, Driving
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import Cause, Effect
from fe_models.files.recording_checks import UNITS
from fe_models.recordings import QUANTITIES, Dataset, Load, Quantity, Recording, Sensor
from fe_models.response import Response
from hybrid.diagnosis.next_measurement.measurements import Measurement

KINDS = ("stiffness_change", "added_mass", "support_spring", "point_damper", "cubic_spring")
CONFIG = BlindConfig(noise=0.05, train=1, test=1, duration=25.0)  # so short and noisy that rivals remain
SIZES = (0.1, 0.6)  # of causes, from 0 to 1 in other blind cases: smaller ones are not seen, larger ones not open
SENSORS = 2
OFFERED: tuple[Quantity, ...] = ("displacement", "acceleration")
BLOW = 1.5  # s: about a period of the fastest mode, as of the blows in other blind cases
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
        """Return the case of a seed."""
        rng, design = np.random.default_rng(seed), four_dof()
        starts = rng.standard_normal((2, CONFIG.campaign.count, len(design.nodes)))
        calm = motion_of(Chain(design), Moved(starts), CONFIG, rng)
        cause = draw_cause(KINDS[seed % len(KINDS)], calm, rng, float(rng.uniform(*SIZES)))
        assert isinstance(cause, Effect)  # no kind of a sensor is drawn
        every = [_sensor(node, quantity) for node in range(1, len(design.nodes) + 1) for quantity in OFFERED]
        kept = np.sort(rng.choice(len(every), SENSORS, replace=False))
        return OpenCase(seed, Chain(design, (cause,)), cause, starts, tuple(every[int(i)] for i in kept))

    def dataset(self, added: Measurement | None = None) -> Dataset:
        """Return the recordings, as they are with what is ``added``."""
        sensors = self.sensors
        if added is not None and added.quantity is not None:
            sensors = (*sensors, _sensor(added.node, added.quantity))
        motion, campaign = self._moved(Moved(self.starts)), CONFIG.campaign
        recordings = [
            Recording(f"r{i + 1:02d}", data[None], "train" if i < campaign.train else "test")
            for i, data in enumerate(self._measured(motion, sensors, motion, 0))
        ]
        if added is not None and added.quantity is None:
            recordings.append(self._excited(added, sensors, motion))
        return Dataset(four_dof(), campaign.sampling_rate, sensors, tuple(recordings))

    def _moved(self, moved: Moved) -> Response:
        return motion_of(self.chain, moved, CONFIG, np.random.default_rng(self.seed))

    def _measured(self, motion: Response, sensors: Sequence[Sensor], usual: Response, first: int) -> FloatArray:
        """Return what ``sensors`` show of a motion (recording, time, sensor), each with its own noise, in proportion to
        what it shows of the ``usual`` motion; ``first``: the number of the first recording.
        """
        channels = []
        for sensor in sensors:
            own = (self.seed, sensor.node, QUANTITIES.index(sensor.quantity), first)
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
            linear = replace(self, chain=Chain(four_dof()))._moved(Moved(start))
            start *= wanted / float(np.sqrt(np.mean(linear.displacement**2)))
            data = self._measured(self._moved(Moved(start)), sensors, usual, number)
            return Recording("pull", data)
        driving = Driving((Load(added.node, "x", _blow()),))
        linear = driven(four_dof(), linearise(four_dof()), (driving,), CONFIG)
        driving = driving.times(wanted / float(np.sqrt(np.mean(linear.displacement**2))))
        config = replace(CONFIG, excitation="measured")
        motion = motion_of(
            self.chain, Moved(np.zeros_like(self.starts[:, :1]), (driving,)), config, np.random.default_rng(self.seed)
        )
        loads = driving.recorded(CONFIG.campaign.sampling_rate).loads
        data = self._measured(motion, sensors, usual, number)
        return Recording("blow", data, loads=loads, excitation="measured")


def _sensor(node: int, quantity: Quantity) -> Sensor:
    return Sensor(f"{quantity[0]}{node}", node, "x", quantity, UNITS[quantity, False])


def _blow() -> FloatArray:
    """Return the course of a blow of unit size, (1 - cos) / 2, with margins."""
    campaign = CONFIG.campaign
    time = (np.arange(campaign.samples + 2 * MARGIN) - MARGIN) / campaign.sampling_rate
    phase = np.clip((time - STRUCK_AT * campaign.duration) / BLOW, 0.0, 1.0)
    return np.asarray((1 - np.cos(2 * np.pi * phase)) / 2)
