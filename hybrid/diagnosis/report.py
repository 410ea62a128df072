"""The report of a diagnosis: as JSON in the contract's words, and in a few lines that an engineer reads."""

from typing import Any

import numpy as np

from hybrid.diagnosis.diagnosis import Diagnosis
from hybrid.diagnosis.findings import Finding, Verdict, place_words

WORDS = {
    Verdict.NOTHING_WRONG: "Nothing is wrong: the simulation, calibrated within its uncertainty, reaches the noise.",
    Verdict.EXPLAINED: "The simulation is wrong, and the cause is named below.",
    Verdict.PARTLY_EXPLAINED: "The simulation is wrong; what is named below explains only part of it.",
    Verdict.UNEXPLAINED: "The simulation is wrong, and nothing on the list of causes explains it.",
}
CALIBRATED = 1e-4  # a smaller change of a factor is not worth a line


def report_table(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return the report as plain data, ready for JSON."""
    return {
        "schema": 1,
        "verdict": diagnosis.verdict.value,
        "findings": [_finding(finding) for finding in diagnosis.findings],
        "calibration": [
            {"what": what, "location": where, "factor": {"value": factor, "std": std}}
            for what, where, factor, std in diagnosis.calibration
            if abs(factor - 1) > CALIBRATED
        ],
        "unexplained_fraction": diagnosis.unexplained,
        "scores": diagnosis.scores,
        "noise_floor": diagnosis.noise_floor,
        "seconds": round(diagnosis.seconds, 2),
        "notes": list(diagnosis.notes),
    }


def _finding(finding: Finding) -> dict[str, Any]:
    return {
        "kind": finding.cause.kind,
        "location": finding.cause.location,
        "parameters": {word: vars(item) for word, item in finding.parameters.items()},
        "probability": finding.probability,
        "explains": finding.explains,
        "recordings": list(finding.recordings),
        "alternatives": [
            {"kind": kind, "location": location, "probability": p} for kind, location, p in finding.alternatives
        ],
        "sentence": finding.sentence,
    }


def describe_diagnosis(diagnosis: Diagnosis) -> str:
    """Return the report in a few lines."""
    shown = diagnosis.shown
    lines = ["What the nominal simulation shows (forecast NRMSE, last 80 % of the test recordings):"]
    lines.append(f"  {'channel':10s} {'nominal':>9s} {'calibrated':>11s} {'noise floor':>12s}")
    for name, (nominal, calibrated, floor) in zip(shown.sensors, shown.errors.T, strict=True):
        known = f"{floor:12.4f}" if np.isfinite(floor) else f"{'held out':>12s}"
        lines.append(f"  {name:10s} {nominal:9.4f} {calibrated:11.4f} {known}")
    lines.append("  mode: frequency nominal -> calibrated (Hz), damping ratio nominal -> calibrated")
    for mode in range(shown.frequencies.shape[1]):
        (f0, f1), (x0, x1) = shown.frequencies[:, mode], shown.ratios[:, mode]
        lines.append(f"  {mode + 1:4d}: {f0:.4f} -> {f1:.4f}, {x0:.4f} -> {x1:.4f}")
    lines += ["", WORDS[diagnosis.verdict]]
    for finding in diagnosis.findings:
        lines.append(f"- {finding.sentence}")
        lines.append(f"  Probability {finding.probability:.2f}; explains {finding.explains:.0%} of what was wrong.")
        for kind, location, p in finding.alternatives[:5]:
            lines.append(f"  These sensors cannot rule out: {kind} at {place_words(location)} ({p:.2f}).")
    base, extended = diagnosis.scores["baseline"], diagnosis.scores["extended"]
    lines.append(
        f"Forecast NRMSE: {base['measured']:.4f} before, {extended['measured']:.4f} after, noise floor"
        f" {diagnosis.noise_floor:.4f}; left unexplained {diagnosis.unexplained:.1%}."
    )
    if base["held_out"] is not None:
        lines.append(f"Held-out sensors: {base['held_out']:.4f} before, {extended['held_out']:.4f} after.")
    lines += [f"Note: {note}." for note in diagnosis.notes]
    return "\n".join(lines)
