"""What was assumed: what the dataset states, what was calibrated within it, and how to repeat the answer."""

from fe_models.causes.wording import place_words
from fe_models.directions import direction_words
from fe_models.linear import LinearModel
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.config import REPORT
from hybrid.report.page import Block, Cell, Heading, Paragraph, Section, Table
from hybrid.report.provenance import Provenance, repeated
from hybrid.report.values import fixed, measured, typeset

MOST_CALIBRATED = 60  # nominal values that are listed, those that moved most
EXCITATIONS = {"free": "free decay", "measured": "known forces or base motion", "ambient": "unknown forces"}
NOT_STATED = "not stated: free decay unless the data speak against it"


def what_was_assumed(
    dataset: Dataset, provenance: Provenance, found: Answer | None = None, settings: Table | None = None
) -> Section:
    """Return what an answer takes for granted; ``settings``: of the program that gave it."""
    blocks: list[Block] = [_stated(dataset)]
    if dataset.recordings:
        blocks.append(_recordings(dataset))
    blocks.append(_sensors(dataset))
    if found is not None:
        blocks += [Heading("Nominal values, calibrated"), _calibrated(found)]
    blocks += [] if settings is None else [settings]
    return Section("assumed", "What was assumed", (*blocks, *repeated(provenance)))


def _stated(dataset: Dataset) -> Table:
    own, spread = dataset.assumptions, dataset.assumptions.uncertainty
    model = dataset.model
    name = "matrices" if isinstance(model, LinearModel) else model.name
    ratios = own.damping_ratio if isinstance(own.damping_ratio, tuple) else (own.damping_ratio,)
    damping = ", ".join(f"{100 * ratio:g} %" for ratio in ratios if ratio is not None) or "the model's own"
    rates = " and ".join(f"{rate:g}" for rate in dataset.sampling_rates or (dataset.sampling_rate,))
    integrator = own.integrator if own.step is None else f"{own.integrator}, steps of {own.step:g} s"
    rows = [
        ("model", name),
        ("sampling rate", f"{rates} Hz" if dataset.recordings else "none: identified modes"),
        ("low-pass", f"{dataset.lowpass:g} Hz" if dataset.lowpass else "none"),
        ("damping ratios", damping),
        ("modal model", "given by the dataset" if own.modal_model is not None else "none: the structure's own modes"),
        ("time integration", integrator),
        ("stiffness is normally within (one standard deviation)", f"{100 * spread.stiffness:g} %"),
        ("mass is normally within", f"{100 * spread.mass:g} %"),
        ("damping is normally within", f"{100 * spread.damping:g} %"),
        ("forecasts are good enough within", f"{100 * own.tolerance:g} % of the noise floor"),
    ]
    cells = tuple((Cell(word), Cell(value)) for word, value in rows)
    return Table("What the dataset states, or leaves to its defaults.", ("quantity", "value"), cells)


def _recordings(dataset: Dataset) -> Table:
    rows = tuple(
        (
            Cell(own.name),
            Cell("fitted" if own.role == "train" else "for testing"),
            Cell(str(len(own.data)), len(own.data)),
            Cell(f"{own.data.shape[1] / dataset.rate_of(own):.4g}", own.data.shape[1] / dataset.rate_of(own)),
            Cell(_moved_by(own)),
        )
        for own in dataset.recordings
    )
    return Table("Recordings.", ("recording", "use", "motions", "length (s)", "moved by"), rows)


def _moved_by(recording: Recording) -> str:
    if recording.is_driven:
        return EXCITATIONS["measured"]
    return NOT_STATED if recording.excitation is None else EXCITATIONS[recording.excitation]


def _sensors(dataset: Dataset) -> Table:
    rows = tuple(
        (
            Cell(own.name),
            Cell(str(own.node), own.node),
            Cell(direction_words(own.direction)),
            Cell(own.quantity),
            Cell("normalised" if own.unit == "1" else typeset(own.unit)),
            Cell("fitted" if own.role == "measured" else "never fitted, only scored"),
        )
        for own in dataset.sensors
    )
    return Table("Sensors.", ("sensor", "node", "direction", "quantity", "unit", "use"), rows)


def _calibrated(found: Answer) -> Block:
    moved = [item for item in found.calibration if abs(item.factor - 1) > REPORT.min_factor_change]
    if not moved:
        return Paragraph("No nominal value was moved.")
    moved.sort(key=lambda item: -abs(item.factor - 1))
    rows = tuple(
        (
            Cell(f"{item.quantity} of {place_words(item.location)}"),
            Cell(measured(item.factor, item.std), item.factor),
            fixed(100 * (item.factor - 1), 2),
        )
        for item in moved[:MOST_CALIBRATED]
    )
    more = len(moved) - MOST_CALIBRATED
    note = f"{more} further values, which moved less, are in report.json." if more > 0 else ""
    caption = "Nominal values that were moved to fit the recordings, those that moved most first."
    return Table(caption, ("value", "times nominal", "change (%)"), rows, note)
