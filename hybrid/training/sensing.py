"""Ambient recordings by a trained model: the motion of the whole structure from all samples, and its scores."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Recording, Sensor
from hybrid.estimation.config import UNCERTAINTY
from hybrid.estimation.experts import Hybrid, fe_counterpart, members_of
from hybrid.estimation.uncertainty import like_measured
from hybrid.estimation.virtual_sensing import SensedMotion, sense
from hybrid.training.scoring import nrmse, r2

WORDS = {"measured": "measured channels", "held_out": "channels never fitted"}


@dataclass(frozen=True, eq=False)
class SensedRecording:
    """``data`` (time, sensor) of an ambient recording about its mean, and the motion that each model finds in it."""

    name: str
    data: FloatArray
    fe: SensedMotion
    hybrid: SensedMotion


def sensed(model: Hybrid, recording: Recording) -> tuple[SensedRecording, ...]:
    """Return each motion of a recording; the FE model estimates forces and noise of its own."""
    fe = fe_counterpart(members_of(model)[0])
    return tuple(
        SensedRecording(recording.name, motion - motion.mean(axis=0), sense(fe, motion), sense(model, motion))
        for motion in recording.data
    )


def sensing_scores(found: Sequence[SensedRecording], sensors: tuple[Sensor, ...]) -> dict[str, Any]:
    """Return NRMSE and R2 of both models and the share inside the hybrid's band, of each role; None without sensors."""
    columns = {role: [i for i, sensor in enumerate(sensors) if sensor.role == role] for role in WORDS}
    inside = np.mean([_inside(each, sensors) for each in found], axis=0)  # (sensor,)
    scores: dict[str, Any] = {"recordings": list(dict.fromkeys(each.name for each in found))}
    for name in ("fe", "hybrid"):
        motions = [(each.data[None], getattr(each, name).motion.channels) for each in found]
        scores[name] = {
            role: {
                "nrmse": float(np.mean([nrmse(shown, data)[0, own] for data, shown in motions])),
                "r2": float(np.mean([r2(shown, data)[0, own] for data, shown in motions])),
            }
            if own
            else None
            for role, own in columns.items()
        }
    scores["inside_band"] = {role: float(inside[own].mean()) if own else None for role, own in columns.items()}
    return scores


def _inside(found: SensedRecording, sensors: tuple[Sensor, ...]) -> FloatArray:
    """Return the share (sensor,) of samples within the hybrid's band that should hold 90 %, sensors' noise included."""
    measured = [i for i, sensor in enumerate(sensors) if sensor.role == "measured"]
    noise = like_measured(dict(zip(measured, found.hybrid.noise_std.tolist(), strict=True)), sensors)
    error = np.abs(found.data - found.hybrid.motion.channels[0])
    reach = UNCERTAINTY.level_sigma * np.hypot(found.hybrid.channels_std, noise)
    return np.asarray(np.mean(error <= reach, axis=0))


def beside_forecasts(metrics: dict[str, Any]) -> list[str]:
    """Return the training's forecasts of its test recordings as lines below `describe_sensing`; none without these."""
    found = metrics.get("scores")
    if not found:
        return []
    lines = ["For comparison, forecasts of the test recordings from their first samples, as the training scored them:"]
    return lines + _rows(found["fe"], found["hybrid"])


def _rows(fe: dict[str, Any], hybrid: dict[str, Any]) -> list[str]:
    """Return a line with both models' scores for each role that has sensors."""
    lines = []
    for role, words in WORDS.items():
        if None not in (fe[role], hybrid[role]):
            lines.append(
                f"{words:26}" + "".join(f"{each[role]['nrmse']:9.4f}{each[role]['r2']:9.3f}" for each in (fe, hybrid))
            )
    return lines


def describe_sensing(scores: dict[str, Any]) -> list[str]:
    """Return the scores of ambient recordings in plain words."""
    names = ", ".join(scores["recordings"])
    lines = [
        f"Ambient, {names}: the motion at all nodes from all samples of the recording, its forces unknown.",
        f"{'':26}{'FE model':^18}{'hybrid':^18}",
        f"{'':26}{'NRMSE':>9}{'R2':>9}{'NRMSE':>9}{'R2':>9}",
        *_rows(scores["fe"], scores["hybrid"]),
    ]
    inside = scores["inside_band"]
    role = "held_out" if inside["held_out"] is not None else "measured"
    lines.append(f"{'inside the 90 % band':26}{'':18}{100 * inside[role]:7.1f} % of the {WORDS[role]}")
    return [*lines, *(f"Warning: {line}." for line in too_narrow(scores))]


def too_narrow(scores: dict[str, Any]) -> list[str]:
    """Return a sentence where the band held clearly less of the record than it should, none elsewhere."""
    found = [inside for inside in scores["inside_band"].values() if inside is not None]
    if min(found) >= UNCERTAINTY.min_coverage:
        return []
    return ["the standard deviations are too small: take them for the least that they may be"]
