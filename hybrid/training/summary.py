"""The scores of a run in plain words, for the terminal."""

from typing import Any

from hybrid.config import Config
from hybrid.estimation.config import UNCERTAINTY, WINDOWS
from hybrid.training.sensing import describe_sensing

SCORES_MEAN = """\
NRMSE is the root mean square error over the range (maximum - minimum) of the window; 0 is perfect.
R2 is the share of the variance that is explained (1 is perfect, 0 no better than the mean, negative worse)."""
MEANING = f"""\
{SCORES_MEAN}
Every number is a forecast of whole windows of recordings that were never trained on, from their first samples."""
NOTHING_LEARNED = """\
The hybrid model forecasts no better than the mean of each channel: it has learned nothing. Likely causes: too few or
too short recordings; a model whose natural frequencies or sensors are not the structure's; a wrong sampling rate."""
GROUPS = {
    "measured channels": ("measured", ""),
    "  first 16 windows": ("measured", "_first_16_windows"),
    "channels never fitted": ("held_out", ""),
    "  their first 16 windows": ("held_out", "_first_16_windows"),
}


def window_notes(windows: int, samples: int, modes: int, config: Config) -> list[str]:
    """Return what a user should know of a model's training windows: that they are short, or too few to learn from.

    An encoder starts at what calibration says of the windows' initial states: it needs as many as a state has parts.
    """
    notes = []
    if config.training.window is None and samples < WINDOWS.default_samples:
        notes.append(
            f"the recordings are short: windows of {samples} samples instead of {WINDOWS.default_samples},"
            f" {windows} of them to train on (--window sets their length)"
        )
    if windows < 2 * modes and config.model.encoder == "window":
        notes.append(
            f"{windows} training window{'s' if windows > 1 else ''} of {samples} samples can hardly teach the initial"
            f" states of {modes} modes, which take {2 * modes}: give longer or more recordings, fewer modes, or a"
            " shorter --window"
        )
    return notes


def describe(metrics: dict[str, Any]) -> str:
    """Return the scores as a table and what they mean."""
    lines = [
        f"Training recording {name} was left out: it contradicts the others, as if the structure had changed."
        for name in metrics["training"]["left_out"]
    ]
    test, scores = metrics["test"], metrics["scores"]
    sensing = describe_sensing(metrics["virtual_sensing"]) if "virtual_sensing" in metrics else []
    if scores is None:
        lines += sensing or ["The dataset has no test recording, so that nothing is scored."]
        return "\n".join([*lines, *(["", SCORES_MEAN] if sensing else [])])
    lines += [
        f"Tested on {', '.join(test['recordings'])}: {test['windows']} windows of {test['window_samples']} samples,"
        f" each forecast from its first {test['encoder_samples']}.",
        *_experts(test.get("expert_weights", {})),
        "",
        f"{'':26}{'FE model':^18}{'hybrid':^18}",
        f"{'':26}{'NRMSE':>9}{'R2':>9}{'NRMSE':>9}{'R2':>9}",
    ]
    for words, (role, part) in GROUPS.items():
        both = [scores[model][role] for model in ("fe", "hybrid")]
        if None not in both and (not part or test["overlapping"]):
            lines.append(f"{words:26}" + "".join(f"{s['nrmse' + part]:9.4f}{s['r2' + part]:9.3f}" for s in both))
    if scores.get("whole_record"):
        whole = {role: scores["whole_record"][role] for role in ("measured", "held_out")}
        for role, words in (("measured", "given whole records"), ("held_out", "  never fitted")):
            if whole[role] is not None:
                lines.append(f"{words:26}{'':18}{whole[role]['nrmse']:9.4f}{whole[role]['r2']:9.3f}")
    for name, words in (("hybrid", "inside the 90 % band"), ("whole_record", "  given whole records")):
        inside = metrics.get("bands", {}).get(name)
        if inside:
            lines.append(f"{words:26}{'':18}{100 * inside['measured']:7.1f} % of the measured channels")
    lines += [f"Warning: {line}." for line in band_warning(metrics)]
    if "field" in metrics:
        field = metrics["field"]
        lines.append(f"{'displacement field (*)':26}{field['fe']:9.4f}{'':9}{field['hybrid']:9.4f}")
        lines.append(
            "(*) all nodes, every window of the first test recording: error over the size of the simulated truth."
        )
    if scores["hybrid"]["measured"]["r2"] <= 0:
        lines += ["", NOTHING_LEARNED]
    return "\n".join([*lines, "", MEANING, *(["", *sensing] if sensing else [])])


def _experts(weights: dict[str, float]) -> list[str]:
    if not weights:
        return []
    parts = [f"{name} (weight {weight:.2f})" for name, weight in weights.items()]
    return [f"Experts, one model each of {', '.join(parts)}."]


def band_warning(metrics: dict[str, Any]) -> list[str]:
    """Return a sentence where the band held clearly less of the test recordings than it should, none elsewhere."""
    inside = metrics.get("bands", {}).get("hybrid", {}).get("measured", 1.0)
    if inside >= UNCERTAINTY.min_coverage:
        return []
    return [
        f"the standard deviations are too small: bands of {UNCERTAINTY.level_sigma:g} either side held "
        f"{100 * inside:.1f} % of the test recordings, not {100 * UNCERTAINTY.level:.0f} %: take them for the least "
        "that they may be"
    ]
