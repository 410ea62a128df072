"""A shear frame of five storeys under ambient vibration: its modes, and which storey lost stiffness between recordings.

Each case is a pair of recordings under forces that nobody knows. Between them 30 % of one storey's stiffness is lost,
each storey's in turn, or nothing is; the frame as drawn is that of the first.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.row import Row
from benchmarks.shear_frame import RATIO, STOREYS, frame_modes, frame_recording, shear_frame
from fe_models.arrays import FloatArray
from fe_models.modes import mac
from fe_models.progress import nothing
from fe_models.recordings import Dataset, Recording, Sensor
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.identification.recording_comparison import Compared, compare_recordings

RATE, SAMPLES = 20.0, 14_400  # Hz; twelve minutes
LOST = 0.3  # of a storey's stiffness
PAIRS, QUICK_PAIRS = 20, 1  # that lost a storey, and as many that lost nothing
FIRST_SEED = 5_000
BEFORE, AFTER = "before", "after"
NEAR_FREQUENCY, NEAR_RATIO, NEAR_MAC = 0.005, 0.2, 0.99  # how near to the truth identified modes are to be


@dataclass(frozen=True)
class PairResult:
    """What two recordings showed: whether each mode of the first has frequency, damping ratio and shape near the truth,
    (mode,) each; whether `compare` and `diagnose` say that something ``changed``; which ``storey`` is named first.
    """

    frequencies: FloatArray
    ratios: FloatArray
    shapes: FloatArray
    compared_changed: bool
    diagnosed_changed: bool
    storey: int | None


def rows(pairs: int = PAIRS, advance: Callable[[], object] = nothing) -> list[Row]:
    """Return the share of modes near the truth, of storeys named first, and of unchanged pairs that are called changed.

    So many ``pairs`` lose a storey, and as many nothing. ``advance`` is called after each pair.
    """
    lost = [STOREYS[number % len(STOREYS)] for number in range(pairs)]
    results = []
    for number, storey in enumerate([*lost, *[None] * pairs]):
        results.append(pair_result(FIRST_SEED + 2 * number, storey))
        advance()
    changed, same = results[:pairs], results[pairs:]
    shares = (
        ("frequencies within 0.5 %", np.mean([own.frequencies for own in results]), ">= 0.95"),
        ("damping ratios within 20 %", np.mean([own.ratios for own in results]), ">= 0.95"),
        ("shapes with a MAC of 0.99 and more", np.mean([own.shapes for own in results]), ">= 0.95"),
        ("30 % of a storey lost: that storey named first", _named(changed, lost), ">= 0.95"),
        ("the same: called changed by compare", np.mean([own.compared_changed for own in changed]), ""),
        ("nothing lost: called changed by compare", np.mean([own.compared_changed for own in same]), "<= 0.02"),
        ("nothing lost: called changed by diagnose", np.mean([own.diagnosed_changed for own in same]), "<= 0.02"),
    )
    return [Row("ambient frame", f"{what} ({pairs} pairs)", float(value), aim=aim) for what, value, aim in shares]


def pair_result(seed: int, storey: int | None) -> PairResult:
    """Return what two recordings of the seeds ``seed`` and the next show; ``storey``: which one lost stiffness."""
    dataset = pair(seed, storey)
    compared, findings = compare_recordings(dataset), diagnose(dataset).findings
    (change,) = compared.changes
    return PairResult(
        *_nearness(compared),
        compared_changed=change.is_plain,
        diagnosed_changed=any(finding.recordings == (AFTER,) for finding in findings),
        storey=_storey(findings[0]) if findings else None,
    )


def pair(seed: int, storey: int | None) -> Dataset:
    """Return two recordings of the frame, before and after a ``storey`` (numbered from the top) lost stiffness."""
    lost = {} if storey is None else {storey: LOST}
    sensors = tuple(Sensor(f"a{node}", node, "x", "acceleration", "m/s^2") for node in STOREYS)
    before = Recording(BEFORE, frame_recording(seed, SAMPLES, RATE)[None], excitation="ambient")
    after = Recording(AFTER, frame_recording(seed + 1, SAMPLES, RATE, lost=lost)[None], excitation="ambient")
    return Dataset(shear_frame(), RATE, sensors, (before, after))


def _nearness(compared: Compared) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return of each true mode of the first recording whether it was found near its frequency, damping and shape."""
    truth, first = frame_modes(), compared.recordings[0]
    found = first.identified
    near = np.zeros((3, len(truth.frequencies)))
    for mode, own in compared.pairs(first):
        rows = [truth.dofs.row(node, "x") for node in STOREYS]
        near[:, mode] = (
            abs(found.frequencies[own] / truth.frequencies[mode] - 1) <= NEAR_FREQUENCY,
            abs(found.ratios[own] / RATIO - 1) <= NEAR_RATIO,
            mac(truth.shapes[rows][:, [mode]], first.shapes[:, [own]])[0, 0] >= NEAR_MAC,
        )
    return near[0], near[1], near[2]


def _storey(finding: Finding) -> int | None:
    """Return which storey's loss of stiffness in the later recording a finding is; None where it is another."""
    if finding.cause.kind != "stiffness_change" or finding.recordings != (AFTER,):
        return None
    element = finding.cause.location.get("element")
    return int(element) if isinstance(element, int) else None


def _named(results: list[PairResult], lost: list[int]) -> float:
    return float(np.mean([own.storey == storey for own, storey in zip(results, lost, strict=True)]))
