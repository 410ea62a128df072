"""Frequency response functions as a table, a file of numbers and a picture."""

import csv
import io
from pathlib import Path

import numpy as np

from hybrid.figures import figure
from hybrid.identification.frequency_response import FrequencyResponse

MAX_PANELS = 24  # of a picture that can still be read
PANEL_HEIGHT = 2.4  # inches


def describe_responses(found: FrequencyResponse) -> str:
    """Return how well loads explain each sensor, and the model the measured functions, as a table in Markdown."""
    first, last = found.frequencies[[0, -1]]
    lines = [
        f"Frequency response functions, {first:.3g} to {last:.3g} Hz, {found.averages} segments: coherence (median; 1:"
        " the loads explain all of the sensor, linearly)",
        "and assurance criterion of the nominal model's functions (1: measured and computed are alike but for a factor;"
        " the factor beside it)",
        "",
        f"| sensor | coherence | {' | '.join(found.inputs)} |",
        f"|---|---|{'---|' * len(found.inputs)}",
    ]
    assurance, factor = found.assurance(), _factors(found)
    for number, sensor in enumerate(found.sensors):
        cells = [f"{a:.3f} ({f:.3g})" for a, f in zip(assurance[:, number], factor[:, number], strict=True)]
        lines.append(f"| {sensor} | {np.median(found.coherence[:, number]):.3f} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _factors(found: FrequencyResponse) -> np.ndarray:
    """Return by which factor (input, sensor) the nominal functions come nearest to the measured ones, its sign real."""
    along = np.sum(found.nominal.conj() * found.measured, axis=0).real
    return np.asarray(along / np.sum(np.abs(found.nominal) ** 2, axis=0))


def responses_csv(found: FrequencyResponse) -> str:
    """Return a row a frequency, input and sensor: measured and nominal real and imaginary part, and coherence."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    parts = ("measured_real", "measured_imag", "nominal_real", "nominal_imag")
    writer.writerow(("frequency_hz", "input", "sensor", *parts, "coherence"))
    for line, frequency in enumerate(found.frequencies.tolist()):
        for i, name in enumerate(found.inputs):
            for j, sensor in enumerate(found.sensors):
                own, model = complex(found.measured[line, i, j]), complex(found.nominal[line, i, j])
                values = (own.real, own.imag, model.real, model.imag, float(found.coherence[line, j]))
                writer.writerow((f"{frequency:.9g}", name, sensor, *(f"{value:.6g}" for value in values)))
    return file.getvalue()


def draw_responses(path: Path, found: FrequencyResponse) -> Path:
    """Draw the size of each function with the model's, and the coherence behind it, a panel an input and sensor."""
    pairs = [(i, j) for i in range(len(found.inputs)) for j in range(len(found.sensors))][:MAX_PANELS]
    columns = min(len(pairs), 2)
    with figure(path, len(pairs), columns, "Frequency response functions (behind: coherence)") as (sheet, axes):
        sheet.set_size_inches(5.2 * columns, PANEL_HEIGHT * -(-len(pairs) // columns) + 0.9)
        for axis, (i, j) in zip(axes, pairs, strict=True):
            behind = axis.twinx()
            behind.fill_between(found.frequencies, found.coherence[:, j], color="#DDDDDD", linewidth=0)
            behind.set(ylim=(0, 1), ylabel="coherence")
            behind.set_zorder(axis.get_zorder() - 1)
            axis.patch.set_visible(False)
            axis.semilogy(found.frequencies, np.abs(found.measured[:, i, j]), color="#555555", label="measured")
            axis.semilogy(
                found.frequencies, np.abs(found.nominal[:, i, j]), color="#E69F00", linestyle="--", label="nominal"
            )
            axis.set(xlabel="frequency (Hz)", ylabel=found.sensors[j])
            axis.set_title(found.inputs[i], fontsize=9)
        sheet.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False)
    return path
