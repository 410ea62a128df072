"""The comparison of recordings as plain data: one table for JSON, and one row a mode and recording for spreadsheets."""

import csv
import io
from typing import Any

import numpy as np

from hybrid.identification.recording_comparison import Compared, Observed

COLUMNS = (
    "recording",
    "mode",
    "frequency_hz",
    "damping_ratio",
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
        "left_by_modes_of_each": {"window_seconds": compared.window, "shares": compared.left.tolist()},
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
        "damping_ratio": float(observed.identified.ratios[number]),
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
        "unexplained_energy": observed.identified.left,
        "seconds": observed.lasts,
        "modes": [{**_row(observed, compared, number), "shape": shapes[number]} for number in observed.shown],
        "while_it_decays": [
            {
                "mode": mode + 1,
                "amplitude": curve.amplitude.tolist(),
                "frequency_hz": curve.frequency.tolist(),
                "frequency_std_hz": curve.deviation.tolist(),
                "damping_ratio": curve.ratio.tolist(),
                "damping_ratio_std": curve.ratio_deviation.tolist(),
            }
            for mode, curve in zip(compared.followed, observed.backbones, strict=True)
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
