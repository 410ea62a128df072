"""The comparison of recordings as plain data: one table for JSON, and one row a mode and recording for spreadsheets."""

import csv
import io
from typing import Any

import numpy as np

from hybrid.identification.mode_changes import RecordingChange
from hybrid.identification.recording_comparison import Compared, Observed

COLUMNS = (
    "recording",
    "mode",
    "frequency_hz",
    "frequency_std_hz",
    "damping_ratio",
    "damping_ratio_std",
    "nominal_frequency_hz",
    "deviation",
    "mac",
    "energy_share",
)


def comparison_table(compared: Compared) -> dict[str, Any]:
    """Return all that was found, for JSON: frequencies in Hz, damping ratios and shares of energy as fractions.

    Modes are numbered from 1, as the model has them; an identified mode that is none of these has null.
    """
    return {
        "schema": 1,
        "sensors": list(compared.sensors),
        "model": [
            {"mode": mode, "frequency": frequency, "shape": shape}
            for mode, (frequency, shape) in enumerate(
                zip(compared.nominal.tolist(), compared.shapes.T.tolist(), strict=True), start=1
            )
        ],
        "recordings": [_recording(observed, compared) for observed in compared.recordings],
        "left_by_modes_of_each": {
            "window_seconds": compared.window,
            "shares": [[None if np.isnan(share) else share for share in row] for row in compared.left.tolist()],
        },
        "changes": [_change(change, compared) for change in compared.changes],
    }


def _change(change: RecordingChange, compared: Compared) -> dict[str, Any]:
    """Return what changed between two recordings."""
    first, last = (compared.recordings[number] for number in change.recordings)
    return {
        "recordings": [first.name, last.name],
        "chance": change.chance,
        "changed": change.is_plain,
        "modes": [
            {
                "mode": first.chosen.index(mode.numbers[0]) + 1 if mode.numbers[0] in first.chosen else None,
                "frequencies_hz": [
                    float(own.identified.frequencies[number])
                    for own, number in zip((first, last), mode.numbers, strict=True)
                ],
                "change": mode.change,
                "change_std": mode.error,
                "damping_ratio_change": mode.ratio_change,
                "damping_ratio_change_std": mode.ratio_error,
                "mac": mode.mac,
            }
            for mode in change.modes
        ],
    }


def comparison_csv(compared: Compared) -> str:
    """Return the modes of all recordings as comma-separated text, one row each; those not of the model lack some."""
    text = io.StringIO()
    rows = csv.DictWriter(text, COLUMNS, lineterminator="\n")
    rows.writeheader()
    for observed in compared.recordings:
        for number in observed.shown:
            rows.writerow({"recording": observed.name, **_row(observed, compared, number)})
    return text.getvalue()


def _row(observed: Observed, compared: Compared, number: int) -> dict[str, Any]:
    """Return what is known of an identified mode, under the names of `COLUMNS`."""
    frequency = float(observed.identified.frequencies[number])
    row: dict[str, Any] = {
        "mode": None,
        "frequency_hz": frequency,
        "frequency_std_hz": float(observed.identified.frequency_errors[number]),
        "damping_ratio": float(observed.identified.ratios[number]),
        "damping_ratio_std": float(observed.identified.ratio_errors[number]),
        "nominal_frequency_hz": None,
        "deviation": None,
        "mac": None,
        "energy_share": float(observed.identified.energy[number]),
    }
    if number in observed.chosen:
        mode = observed.chosen.index(number)
        nominal = float(compared.nominal[mode])
        row |= {"mode": mode + 1, "nominal_frequency_hz": nominal, "deviation": frequency / nominal - 1}
        row["mac"] = float(observed.criterion[mode, number])
    return row


def _recording(observed: Observed, compared: Compared) -> dict[str, Any]:
    shapes = observed.shapes.T.tolist()
    return {
        "name": observed.name,
        "taken_as": "ambient" if observed.found.is_ambient else "free",
        "note": observed.found.note,
        "harmonics": [
            {"frequency_hz": line.frequency, "amplitude": line.amplitude.tolist(), "energy_share": line.share}
            for line in observed.found.harmonics
        ],
        "unexplained_energy": observed.identified.left,
        "seconds": observed.lasts,
        "coordinate_mac": [None if np.isnan(value) else value for value in compared.coordinate_mac(observed).tolist()],
        "mac": observed.criterion[:, observed.shown].tolist(),
        "modes": [{**_row(observed, compared, number), "shape": shapes[number]} for number in observed.shown],
        "while_it_decays": [
            {
                "mode": mode + 1,
                "amplitude_at": compared.sensors[observed.loudest(mode)],
                "amplitude": curve.amplitude.tolist(),
                "frequency_hz": curve.frequency.tolist(),
                "frequency_std_hz": curve.deviation.tolist(),
                "damping_ratio": curve.ratio.tolist(),
                "damping_ratio_std": curve.ratio_deviation.tolist(),
            }
            for mode, curve in zip(compared.followed, observed.backbones, strict=not observed.found.is_ambient)
        ],
        "combinations": [
            {
                "of_modes": [mode + 1 for mode in compared.followed],
                "factors": [each.first, each.second][: len(compared.followed)],
                "expected_hz": each.expected,
                "found_hz": None if np.isnan(each.found) else each.found,
                "power_over_surroundings": None if np.isnan(each.over) else each.over,
                "natural_mode_there": None if each.natural < 0 else each.natural + 1,
            }
            for each in observed.combinations
        ],
    }
