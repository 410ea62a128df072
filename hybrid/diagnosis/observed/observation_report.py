"""What the nominal simulation gets wrong, as tables for a terminal and as plain data."""

from typing import Any

import numpy as np

from hybrid.diagnosis.observed.amplitude_dependence import Amplitude
from hybrid.diagnosis.observed.config import OBSERVATION
from hybrid.diagnosis.observed.observations import Modes, Observations
from hybrid.diagnosis.recorded.config import SPECTRA


def describe_observations(shown: Observations) -> list[str]:
    """Return tables of channels, modes and amplitudes."""
    return [
        "What the nominal simulation shows (forecast NRMSE over the last 80 % of each recording):",
        f"  {'channel':12s} {'nominal':>9s} {'calibrated':>11s} {'noise floor':>12s} {'noise (std)':>18s}"
        f" {'share of error':>15s}",
        *_channels(shown),
        "  The modes: nominal; calibrated, with nominal values moved within their uncertainty; and observed, of the",
        "  linear model that follows the recordings best (-: hardly seen). Shares of each in the energy of the",
        "  recorded motion and of the nominal simulation's error:",
        f"  {'':4s} {'frequency (Hz)':^30s} {'damping ratio':^28s} {'shapes':>6s} {'share of':>9s} {'share of':>9s}",
        f"  {'mode':4s} {'nominal':>9s} {'calibrated':>10s} {'observed':>9s} {'nominal':>8s} {'calibrated':>10s}"
        f" {'observed':>8s} {'MAC':>6s} {'motion':>9s} {'error':>9s}",
        *_modes(shown),
        *([] if shown.amplitude is None else _amplitude(shown.amplitude)),
    ]


def observations_table(shown: Observations) -> dict[str, Any]:
    """Return the same as plain data, ready for JSON; None where a sensor is not fitted."""
    channels = [
        {
            "name": sensor.name,
            "nominal": float(errors[0]),
            "calibrated": float(errors[1]),
            "noise_floor": _number(errors[2]),
            "noise_std": _number(noise),
            "share_of_error": _number(share),
        }
        for sensor, errors, noise, share in zip(
            shown.sensors, shown.errors.T, shown.noise, shown.error_share, strict=True
        )
    ]
    by_name: dict[str, Modes] = {
        "nominal": shown.nominal,
        "calibrated": shown.calibrated,
        "observed": shown.observed,
    }
    modes = {
        name: {"frequencies": each.frequencies.tolist(), "damping_ratios": each.ratios.tolist()}
        for name, each in by_name.items()
    }
    energy = {"motion": shown.motion_energy.tolist(), "error": shown.error_energy.tolist()}
    sizes = None if shown.amplitude is None else {key: part.tolist() for key, part in vars(shown.amplitude).items()}
    return {
        "channels": channels,
        "modes": modes,
        "mac": shown.mac.tolist(),
        "energy_by_mode": energy,
        "amplitude": sizes,
    }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _channels(shown: Observations) -> list[str]:
    lines = []
    rows = zip(shown.sensors, shown.errors.T, shown.noise, shown.error_share, strict=True)
    for sensor, (nominal, calibrated, floor), noise, share in rows:
        line = f"  {sensor.name:12s} {nominal:9.4f} {calibrated:11.4f}"
        known = np.isfinite(noise)
        lines.append(
            line + (f" {floor:12.4f} {f'{noise:.3g} {sensor.unit}':>18s} {share:15.0%}" if known else "     held out")
        )
    return lines


def _modes(shown: Observations) -> list[str]:
    count = min(len(each.frequencies) for each in (shown.nominal, shown.calibrated, shown.observed))
    lines = []
    for mode in range(count):
        three = (shown.nominal, shown.calibrated, shown.observed)
        drawn, *others = (each.frequencies[mode] for each in three)
        drawn_ratio, *other_ratios = (each.ratios[mode] for each in three)
        if shown.motion_energy[mode] >= SPECTRA.min_energy_share:
            after = [f"{value:{width}.4f}" for value, width in zip(others, (10, 9), strict=True)]
            ratios = [f"{value:z{width}.4f}" for value, width in zip(other_ratios, (10, 8), strict=True)]
        else:  # a mode that is hardly seen may be calibrated and observed anywhere
            after, ratios = [f"{'-':>10s}", f"{'-':>9s}"], [f"{'-':>10s}", f"{'-':>8s}"]
        lines.append(
            f"  {mode + 1:4d} {drawn:9.4f} {' '.join(after)} {drawn_ratio:z8.4f} {' '.join(ratios)}"
            f" {shown.mac[mode]:6.3f} {shown.motion_energy[mode]:9.0%} {shown.error_energy[mode]:9.0%}"
        )
    return lines


def _amplitude(found: Amplitude) -> list[str]:
    lines = [
        "  Change from the observed values above, all modes in common, with the motion's size (rms over the largest):",
        f"  {'size':>6s} {'frequency':>18s} {'damping':>18s}",
    ]
    for size, f, f_std, d, d_std in zip(*vars(found).values(), strict=True):
        lines.append(f"  {size:6.0%} {f:+8.2%} +- {f_std:6.2%} {d:+8.0%} +- {d_std:6.0%}")
    change = found.frequency[-1] - found.frequency[0]
    std = float(np.hypot(found.frequency_std[-1], found.frequency_std[0]))
    if abs(change) <= OBSERVATION.min_change_sigma * std:
        return [*lines, "  No change of stiffness with amplitude is detected."]
    word = "stiffer" if change > 0 else "softer"
    return [
        *lines,
        f"  The structure is {word} where it moves more: what is wrong is not linear, or changes as motions die away.",
    ]
