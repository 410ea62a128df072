"""What would decide: the added sensor that best distinguishes a finding from the rivals that the present ones cannot
rule out.

The best hypothesis moves the structure as in the recordings; its rival is fitted to what the present sensors and one
more would then show (to first order: one Gauss-Newton step from where the rival was fitted). What is left of the sum of
squares is what the added sensor would add.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate
from fe_models.causes.places import MIN_MOTION_SHARE
from fe_models.causes.wording import at_place
from fe_models.directions import direction_words
from fe_models.files.recording_checks import UNITS
from fe_models.recordings import Quantity, Sensor
from hybrid.diagnosis.contest.posterior import Posterior, rivals_of, twins_of
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.fitting.linearisation import linearise_batch
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import drifted

DOUBTFUL = 0.05  # least probability of a rival worth a sensor; one that falls below it is ruled out
MUCH_LESS = 0.3  # times a rival's probability: a sensor that makes it so helps
RIVALS = 3  # of each finding, the most probable
TRIED = 3  # sensors at which the rival may move as it pleases; chosen by how far apart the two are if it does not
OFFERED: tuple[Quantity, ...] = ("displacement", "acceleration")


@dataclass(frozen=True)
class Advice:
    """A finding's ``kind`` and ``location``, its ``rival``'s and that one's ``probability``.

    ``sensor``: the added one that decides most, None where none decides anything; ``then``: the rival's probability to
    expect with it, if the finding is right.
    """

    kind: str
    location: dict[str, Any]
    rival: str
    rival_location: dict[str, Any]
    probability: float
    sensor: Sensor | None
    then: float

    @property
    def sentence(self) -> str:
        """What to do, in words."""
        what = f"{self.rival} {at_place(self.rival_location)}"
        told = f"{self.kind} {at_place(self.location)} and {what}"
        if self.sensor is None:
            return f"no added sensor tells {told} apart; look at the structure there"
        where = f"{self.sensor.quantity} at node {self.sensor.node} in {direction_words(self.sensor.direction)}"
        if self.then < DOUBTFUL:
            return f"a sensor of the {where} would tell {told} apart"
        falls = f"the latter's probability falls from {self.probability:.2f} to {self.then:.2f}"
        if self.then < MUCH_LESS * self.probability:
            return f"a sensor of the {where} would help to tell {told} apart: {falls}"
        return f"even a sensor of the {where} hardly tells {told} apart ({falls}): record more or larger motions"


def advise(posterior: Posterior, searched: NoiseModel, present: tuple[Sensor, ...]) -> tuple[Advice, ...]:
    """Return advice for each cause of the best hypothesis and each of its rivals that is not improbable.

    ``searched``: with what counted as noise in the search, see `Evidence`; ``present``: all sensors, also those that
    are never fitted.
    """
    best = posterior.fits[0]
    added = possible_sensors(best.hypothesis.nominal, present)
    found = []
    for candidate in best.hypothesis.candidates:
        for rival, probability in _rivals(posterior, candidate)[:RIVALS]:
            item = _fit_with(posterior, candidate, rival)
            sensor, log_odds = (None, 0.0) if item is best else _most_informative(best, item, added, searched)
            left = probability * float(np.exp(-log_odds / posterior.temper))
            found.append(
                Advice(
                    candidate.kind,
                    candidate.reported_location,
                    rival.kind,
                    rival.reported_location,
                    probability,
                    sensor,
                    left / (1 - probability + left),
                )
            )
    return tuple(found)


def possible_sensors(nominal: NominalModel, present: tuple[Sensor, ...]) -> tuple[Sensor, ...]:
    """Return a displacement and an acceleration sensor for each translation that moves and has none yet."""
    have = {(s.node, s.direction, s.quantity) for s in present}
    found = []
    moved = np.abs(nominal.modes[1]).max(axis=1)
    own = nominal.dofs.node <= len(nominal.structure.nodes)  # finer meshes have more, which no file can name
    for row in np.flatnonzero(own & (moved > MIN_MOTION_SHARE * moved.max())):
        node, direction = int(nominal.dofs.node[row]), nominal.dofs.direction[row]
        for quantity in OFFERED:
            if direction != "rz" and (node, direction, quantity) not in have:
                name = f"{quantity} {node} {direction}"
                found.append(Sensor(name, node, direction, quantity, UNITS[quantity, False]))
    return tuple(found)


def _rivals(posterior: Posterior, candidate: Candidate) -> list[tuple[Candidate, float]]:
    """Return a candidate's rivals that are not improbable; one for all those places at which another would do the
    same: what distinguishes it distinguishes them.
    """
    found = rivals_of(posterior, candidate, DOUBTFUL)
    others = {twin.key for rival, _ in found for twin in twins_of(rival)}
    return [item for item in found if item[0].key not in others]


def _fit_with(posterior: Posterior, candidate: Candidate, rival: Candidate) -> Fit:
    """Return the most probable fit that has the rival in the candidate's place; of its own twin, the candidate's."""
    if any(twin.key == rival.key for twin in twins_of(candidate)):
        return posterior.fits[0]
    wanted = {other.key for other in posterior.fits[0].hypothesis.candidates} - {candidate.key} | {rival.key}
    return next(item for item in posterior.fits if {c.key for c in item.hypothesis.candidates} == wanted)


def _most_informative(
    best: Fit, rival: Fit, added: tuple[Sensor, ...], noise_model: NoiseModel
) -> tuple[Sensor | None, float]:
    """Return the sensor among those ``added`` that decides most, and the log odds it adds; None where none does."""
    ours, theirs = shown_by(best, added, noise_model), shown_by(rival, added, noise_model)
    sigma = noise_of(added, size_of(ours), noise_model, size_of(shown_by(best, noise_model.sensors, noise_model)))
    if not all(np.isfinite(part).all() for part in (*ours.values(), *theirs.values())):
        return None, 0.0
    apart = np.sum([np.sum(((ours[key] - theirs[key]) / sigma) ** 2, axis=0) for key in ours], axis=0)  # (sensor,)
    without = _left(best, rival, noise_model)
    gains: list[tuple[float, int]] = []
    for number in [int(i) for i in np.argsort(-apart)[:TRIED]]:
        wider = NoiseModel(
            (*noise_model.sensors, added[number]), noise_model.rate, np.append(noise_model.sigma, sigma[number])
        )
        gains.append((_left(best, rival, wider) - without, number))
    gain, number = max(gains, default=(0.0, 0))
    return (added[number], gain / 2) if gain > 1 else (None, 0.0)  # less than one is what chance alone makes


def noise_of(added: tuple[Sensor, ...], sizes: FloatArray, noise_model: NoiseModel, shown: FloatArray) -> FloatArray:
    """Return the noise (sensor,) to expect of ``added`` sensors: that of the present ones of their quantity.

    Where there are none, as large beside the largest channel as theirs: ``sizes`` of the added channels (sensor,), and
    ``shown`` by the present ones (sensor,).
    """
    wanted = np.array([sensor.quantity for sensor in added])
    measured = np.array(["rotation" if sensor.turns else sensor.quantity for sensor in noise_model.sensors])
    relative, noise = float(np.median(noise_model.sigma / shown)), np.zeros(len(added))
    for quantity in OFFERED:
        own, present = wanted == quantity, measured == quantity
        noise[own] = np.median(noise_model.sigma[present]) if present.any() else relative * sizes[own].max(initial=0.0)
    return noise


def _left(best: Fit, rival: Fit, noise_model: NoiseModel) -> float:
    """Return the least cost (a chi-square) of the rival on what the sensors of ``noise_model`` show of the best fit."""
    shown = shown_by(best, noise_model.sensors, noise_model)
    precision, off = rival.hypothesis.precision, rival.theta - rival.hypothesis.centre
    H, g, cost = np.diag(precision), -precision * off, float(off @ (precision * off))
    for batch, states in zip(rival.batches, rival.states, strict=True):
        data = np.stack([shown[data.tobytes()] for data in batch.data])
        part = linearise_batch(
            rival.hypothesis, rival.theta, replace(batch, data=data, noise=None), noise_model, states
        )
        if part is None:
            return 0.0
        J, r = part.slopes.reshape(len(off), -1), part.residual.ravel()
        H, g, cost = H + J @ J.T, g + J @ r, cost + float(r @ r)
    return cost - float(g @ np.linalg.solve(H, g))


def shown_by(item: Fit, sensors: tuple[Sensor, ...], noise_model: NoiseModel) -> dict[bytes, FloatArray]:
    """Return what ``sensors`` would show of a fit without noise (time, sensor), by the recording's own data."""
    present = {sensor.name: position for position, sensor in enumerate(noise_model.sensors)}
    outputs = SensorOutputs(sensors, noise_model.rate, tuple(present.get(sensor.name, -1) for sensor in sensors))
    found: dict[bytes, FloatArray] = {}
    for batch, states in zip(item.batches, item.states, strict=True):
        theta = item.theta[item.hypothesis.parameters_of(batch.off)]
        system = system_of(item.hypothesis.less(batch.off), theta[None], outputs)
        y = (respond(system, states[None], batch.samples, batch.loads) + drifted(system, batch.begins))[0]
        found |= {data.tobytes(): motion for data, motion in zip(batch.data, y, strict=True)}
    return found


def size_of(motions: dict[bytes, FloatArray]) -> FloatArray:
    """Return the rms of each sensor's channel (sensor,) over all recordings."""
    return np.sqrt(np.concatenate([part**2 for part in motions.values()]).mean(axis=0))
