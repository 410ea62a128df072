"""What diagnoses and comparisons leave in their folders; light to load, so that a folder is checked before the work."""

from pathlib import Path

from fe_models.files.result_set import ResultSet

REPORT, SUMMARY = "report.json", "summary.txt"
PAGE = "report.html"
WATCH_PAGE = "watch.html"
EXTENDED, EXTENDED_MATRICES = "extended_model.toml", "extended_matrices.npz"
PICTURE, MODES = "what_is_wrong.png", "modes.png"
COMPARISON, COMPARISON_TABLE, COMPARISON_ROWS = "comparison.txt", "comparison.json", "comparison.csv"
BACKBONES, SPECTRA, STABILISATION = "backbones.png", "spectra.png", "stabilisation.png"
MAC, COORDINATE_MAC = "mac.png", "comac.png"
RESPONSES, RESPONSE_ROWS = "frequency_response.png", "frequency_response.csv"


def diagnosis_in(folder: Path) -> ResultSet:
    """Return what a diagnosis leaves in ``folder``."""
    return ResultSet(folder, "diagnose", (REPORT, SUMMARY, PAGE, EXTENDED, EXTENDED_MATRICES, PICTURE, MODES))


def comparison_in(folder: Path) -> ResultSet:
    """Return what a comparison of recordings leaves in ``folder``."""
    pictures = (BACKBONES, SPECTRA, STABILISATION, MAC, COORDINATE_MAC, RESPONSES)
    return ResultSet(folder, "compare", (PAGE, COMPARISON, COMPARISON_TABLE, COMPARISON_ROWS, RESPONSE_ROWS, *pictures))


def watch_in(folder: Path) -> ResultSet:
    """Return what a watch leaves in ``folder`` beside what it keeps."""
    return ResultSet(folder, "watch", (WATCH_PAGE,))
