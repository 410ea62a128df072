"""A comparison of recordings in a folder: what is printed first, then its pictures."""

from pathlib import Path

from fe_models.files.atomic import write_text
from fe_models.recordings import Dataset
from hybrid.identification.comparison_report import describe_compared, draw_backbones, draw_spectra
from hybrid.identification.recording_comparison import Compared
from hybrid.result_sets import BACKBONES, COMPARISON, SPECTRA, comparison_in


def save_comparison(compared: Compared, dataset: Dataset, folder: Path) -> None:
    """Replace the older comparison in ``folder``, none of whose files stays beside the new one."""
    results = comparison_in(folder)
    with results.replacing() as new:
        write_text(new / COMPARISON, describe_compared(compared) + "\n")
    with results.adding() as new:
        draw_backbones(new / BACKBONES, compared)
        draw_spectra(new / SPECTRA, dataset, compared)
