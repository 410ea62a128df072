"""A comparison of recordings in a folder: what is printed and its tables first, then its pictures."""

from collections.abc import Iterator
from pathlib import Path

from fe_models.files.atomic import write_json, write_text
from hybrid.figures import Sheet
from hybrid.identification.comparison_pictures import draw_backbones, draw_spectra
from hybrid.identification.comparison_tables import comparison_csv, comparison_table
from hybrid.identification.dataset_comparison import DatasetComparison
from hybrid.identification.frequency_response_report import draw_responses, responses_csv
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


def save_comparison(found: DatasetComparison, folder: Path) -> dict[str, Sheet]:
    """Replace the older comparison in ``folder``, none of whose files stays beside the new one.

    Return its pictures by the names of their files.
    """
    compared, responses = found.compared, found.responses
    results, sheets = comparison_in(folder), dict[str, Sheet]()
    with results.replacing() as new:
        write_text(new / COMPARISON, found.text + "\n")
        if compared is not None:
            write_json(new / COMPARISON_TABLE, comparison_table(compared))
            write_text(new / COMPARISON_ROWS, comparison_csv(compared))
        if responses is not None:
            write_text(new / RESPONSE_ROWS, responses_csv(responses))
    with results.adding() as new:
        for name, sheet in _pictures(found):
            sheet.save(new / name)
            sheets[name] = sheet
    return sheets


def _pictures(found: DatasetComparison) -> Iterator[tuple[str, Sheet]]:
    compared, free, responses = found.compared, found.free, found.responses
    if compared is not None and free is not None:
        if any(not observed.found.is_ambient for observed in compared.recordings):
            yield BACKBONES, draw_backbones(free, compared)
        yield SPECTRA, draw_spectra(free, compared)
        yield STABILISATION, draw_stabilisation(free, compared)
        yield MAC, draw_mac(compared)
        yield COORDINATE_MAC, draw_coordinate_mac(compared)
    if responses is not None:
        yield RESPONSES, draw_responses(responses)
