"""A comparison of recordings in a folder: what is printed and its tables first, then its pictures."""

from pathlib import Path

from fe_models.files.atomic import write_json, write_text
from fe_models.recordings import Dataset
from hybrid.identification.comparison_pictures import draw_backbones, draw_spectra
from hybrid.identification.comparison_report import describe_compared
from hybrid.identification.comparison_tables import comparison_csv, comparison_table
from hybrid.identification.frequency_response import FrequencyResponse
from hybrid.identification.frequency_response_report import describe_responses, draw_responses, responses_csv
from hybrid.identification.recording_comparison import Compared
from hybrid.identification.shape_pictures import draw_coordinate_mac, draw_mac
from hybrid.identification.stabilisation_picture import draw_stabilisation
from hybrid.result_sets import (
    BACKBONES,
    COMPARISON,
    COMPARISON_ROWS,
    COMPARISON_TABLE,
    COORDINATE_MAC,
    MAC,
    RESPONSE_ROWS,
    RESPONSES,
    SPECTRA,
    STABILISATION,
    comparison_in,
)


def save_comparison(compared: Compared, dataset: Dataset, folder: Path) -> None:
    """Replace the older comparison in ``folder``, none of whose files stays beside the new one."""
    results = comparison_in(folder)
    with results.replacing() as new:
        write_text(new / COMPARISON, describe_compared(compared) + "\n")
        write_json(new / COMPARISON_TABLE, comparison_table(compared))
        write_text(new / COMPARISON_ROWS, comparison_csv(compared))
    with results.adding() as new:
        if any(not observed.found.is_ambient for observed in compared.recordings):
            draw_backbones(new / BACKBONES, dataset, compared)
        draw_spectra(new / SPECTRA, dataset, compared)
        draw_stabilisation(new / STABILISATION, dataset, compared)
        draw_mac(new / MAC, compared)
        draw_coordinate_mac(new / COORDINATE_MAC, compared)


def save_responses(found: FrequencyResponse, folder: Path, alone: bool) -> None:
    """Write frequency response functions into ``folder``; ``alone``: without a comparison of modes, in whose place."""
    results = comparison_in(folder)
    if alone:
        with results.replacing() as new:
            write_text(new / COMPARISON, describe_responses(found) + "\n")
            write_text(new / RESPONSE_ROWS, responses_csv(found))
    else:
        with results.adding() as new:
            write_text(new / RESPONSE_ROWS, responses_csv(found))
    with results.adding() as new:
        draw_responses(new / RESPONSES, found)
