"""Frequency response functions as a table, a file of numbers and a picture."""

import csv
import io
from typing import Any

import numpy as np

from hybrid.figures import Sheet, figure
from hybrid.identification.frequency_response import FrequencyResponse

MAX_PANELS = 24  # of a picture that can still be read
PANEL_HEIGHT = 2.4  # inches
LINES: dict[str, dict[str, Any]] = {  # colours of Okabe & Ito: distinguished by everyone
    "nominal": {"color": "#E69F00", "linestyle": "--"},
    "extended": {"color": "#0072B2", "linewidth": 1.1},
}


def describe_responses(found: FrequencyResponse) -> str:
    """Return how well loads explain each sensor, and each model the measured functions, as tables in Markdown."""
    first, last = found.frequencies[[0, -1]]
    columns = [(model, item) for item in found.inputs for model in found.models]
    heads = [item if len(found.models) == 1 else f"{item}, {model}" for model, item in columns]
    lines = [
        f"Frequency response functions, {first:.3g} to {last:.3g} Hz, {found.averages} segments: coherence (median; 1:"
        " the loads explain all of the sensor, linearly)",
        f"and assurance criterion of the {' and the '.join(found.models)} model's functions (1: measured and computed"
        " are alike but for a factor; the factor beside it)",
        "",
        f"| sensor | coherence | {' | '.join(heads)} |",
        f"|---|---|{'---|' * len(heads)}",
    ]
    assurance = {model: found.assurance(own) for model, own in found.models.items()}
    factor = {model: found.factor(own) for model, own in found.models.items()}
    for number, sensor in enumerate(found.sensors):
        places = [(model, found.inputs.index(item)) for model, item in columns]
        cells = [f"{assurance[model][i, number]:.3f} ({factor[model][i, number]:.3g})" for model, i in places]
        lines.append(f"| {sensor} | {np.median(found.coherence[:, number]):.3f} | {' | '.join(cells)} |")
    apart = ", ".join(f"{model} {found.deviation(own).mean():.1%}" for model, own in found.models.items())
    lines += ["", f"Deviation of the models' functions from the measured ones, over their size, on average: {apart}"]
    if found.left_out:
        lines.append(f"Functions are those of small motion: {', '.join(found.left_out)} of the models is not in them")
    return "\n".join(lines)


def responses_csv(found: FrequencyResponse) -> str:
    """Return a row a frequency, input and sensor: real and imaginary part, measured and of each model; coherence."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    courses = {"measured": found.measured} | found.models
    parts = [f"{name}_{part}" for name in courses for part in ("real", "imag")]
    writer.writerow(("frequency_hz", "input", "sensor", *parts, "coherence"))
    for line, frequency in enumerate(found.frequencies.tolist()):
        for i, name in enumerate(found.inputs):
            for j, sensor in enumerate(found.sensors):
                own = [complex(course[line, i, j]) for course in courses.values()]
                values = [*(part for value in own for part in (value.real, value.imag)), found.coherence[line, j]]
                writer.writerow((f"{frequency:.9g}", name, sensor, *(f"{value:.6g}" for value in values)))
    return file.getvalue()


def draw_responses(found: FrequencyResponse) -> Sheet:
    """Draw the size of each function with the model's, and the coherence behind it, a panel an input and sensor."""
    pairs = [(i, j) for i in range(len(found.inputs)) for j in range(len(found.sensors))][:MAX_PANELS]
    columns = min(len(pairs), 2)
    with figure(len(pairs), columns, "Frequency response functions (behind: coherence)") as (sheet, axes):
        sheet.figure.set_size_inches(5.2 * columns, PANEL_HEIGHT * -(-len(pairs) // columns) + 0.9)
        for axis, (i, j) in zip(axes, pairs, strict=True):
            behind = axis.twinx()
            behind.fill_between(found.frequencies, found.coherence[:, j], color="#DDDDDD", linewidth=0)
            behind.set(ylim=(0, 1), ylabel="coherence")
            behind.set_zorder(axis.get_zorder() - 1)
            axis.patch.set_visible(False)
            axis.semilogy(found.frequencies, np.abs(found.measured[:, i, j]), color="#555555", label="measured")
            for name, own in found.models.items():
                axis.semilogy(found.frequencies, np.abs(own[:, i, j]), label=name, **LINES[name])
            axis.set(xlabel="frequency (Hz)", ylabel=found.sensors[j])
            axis.set_title(found.inputs[i], fontsize=9)
        sheet.figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    return sheet
