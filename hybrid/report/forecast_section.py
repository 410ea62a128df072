"""How much better the structure with what was found forecasts: recordings and sensors that were never fitted."""

import numpy as np

from fe_models.directions import direction_words
from fe_models.recordings import Dataset
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.learned.gain import Gain
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.observed.example import Example, draw_example
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.outcome.verdict import is_at_floor
from hybrid.report.drawings import drawn
from hybrid.report.page import Block, Cell, Paragraph, Section, Table
from hybrid.report.values import fixed

NO_FORECASTS = (
    "No forecasts were made: they need recordings, of free decays or under known forces, of which one at least is not"
    " fitted."
)
HOW = (
    "A forecast goes on from the first fifth of a recording; its error is taken over the rest. NRMSE: root mean square"
    " of the error over the channel's range, mean over channels. The noise floor is an estimate of a perfect"
    " model's error; a forecast may lie below it."
)
TESTED = "Recordings that were kept for testing, and never fitted, are forecast: {names}."
NOT_REACHED = "The error is still {ratio:.2g} times the noise floor: something is left, see “What is not known”."
REACHED = "The error is at the noise floor: a perfect model would forecast no better."
PART = "; on the right the part where they differ most"
IN_TURN = "No recording was kept for testing: each is forecast by what was found in the others."
ALONE = (
    "One that is the only one of its state is forecast by the modes of its own first fifth besides: so little is known"
    " of it that its error may lie above the noise floor though nothing is left."
)


def how_much_better(found: Answer, dataset: Dataset, gain: Gain | None = None) -> Section:
    """Return the scores before and after, a recording as both forecast it, and its channels one by one."""
    title = "How much better"
    if found.noise_floor is None or found.example is None:
        return Section("better", title, (Paragraph(NO_FORECASTS),))
    tests = list(dict.fromkeys(recording.name for recording in dataset.select("test")))
    which = TESTED.format(names=_listed(tests)) if tests else IN_TURN
    alone = isinstance(found, ModalDiagnosis) and found.forecasts is not None and found.forecasts.alone
    if alone:
        which = f"{which} {ALONE}"
    blocks: list[Block] = [Paragraph(f"{which} {HOW}"), _scores(found, gain)]
    error = found.scores["extended"]["measured"]
    if is_at_floor(error, found.noise_floor, dataset.assumptions.tolerance):
        blocks.append(Paragraph(REACHED))
    elif error is not None and error > VERDICT.max_near_ratio * found.noise_floor and not alone:
        blocks.append(Paragraph(NOT_REACHED.format(ratio=error / found.noise_floor)))
    example, after = found.example, "with what was found" if found.findings else "calibrated"
    blocks.append(
        drawn(
            draw_example(example),
            "forecast",
            f"Recording {example.recording} as measured, as the drawn structure forecasts it (nominal) and {after}"
            f" (extended){PART if example.is_long else ''}; below, the spectra of the errors with the natural"
            " frequencies.",
            f"Curves of {len(example.sensors)} channels of {example.recording} over time: measured, nominal, extended,"
            f" and the spectra of the errors.",
        )
    )
    blocks.append(_channels(example))
    return Section("better", title, tuple(blocks))


def _listed(names: list[str], most: int = 8) -> str:
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")


def _scores(found: Answer, gain: Gain | None) -> Table:
    rows = [("as drawn", found.scores["baseline"]), ("with what was found", found.scores["extended"])]
    if not found.findings:
        rows[1] = ("calibrated", found.scores["extended"])
    if gain is not None:
        learned = (("nominal", gain.nominal), ("extended", gain.extended))
        for name, own in learned:
            if own is not None:
                rows.append((f"hybrid on the {name} structure", {"measured": own.measured, "held_out": own.held_out}))
    rows.append(("noise floor", {"measured": found.noise_floor, "held_out": None}))
    cells = tuple((Cell(name), fixed(own["measured"], 4), fixed(own["held_out"], 4)) for name, own in rows)
    return Table("Forecast errors (NRMSE).", ("model", "measured sensors", "sensors never fitted"), cells)


def _channels(example: Example) -> Table:
    span = np.maximum(np.ptp(example.measured, axis=0), np.finfo(float).tiny)
    errors = [
        np.sqrt(np.mean((example.measured - own) ** 2, axis=0)) / span for own in (example.nominal, example.extended)
    ]
    rows = tuple(
        (
            Cell(sensor.name),
            Cell(f"node {sensor.node} in {direction_words(sensor.direction)}"),
            Cell(sensor.quantity),
            Cell("yes" if sensor.role == "measured" else "never"),
            fixed(float(before), 4),
            fixed(float(after), 4),
        )
        for sensor, before, after in zip(example.sensors, *errors, strict=True)
    )
    columns = ("channel", "place", "quantity", "fitted", "as drawn", "with what was found")
    return Table(f"Forecast errors (NRMSE) of each channel of {example.recording}.", columns, rows)
