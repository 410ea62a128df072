"""A comparison in a folder and on its page: figures are drawn once, and none of them at the cost of numbers."""

from dataclasses import replace
from pathlib import Path
from typing import Any, NoReturn

import matplotlib.figure
import pytest

from fe_models.files.result_list import LIST_FILE
from hybrid.identification import comparison_files
from hybrid.identification.comparison_files import save_comparison
from hybrid.identification.dataset_comparison import DatasetComparison, compare_dataset
from hybrid.report.comparison_page import comparison_page
from hybrid.report.drawings import drawn
from hybrid.report.rendering import rendered
from hybrid.result_sets import (
    BACKBONES,
    COMPARISON,
    COMPARISON_ROWS,
    COMPARISON_TABLE,
    COORDINATE_MAC,
    MAC,
    SPECTRA,
    STABILISATION,
)
from tests.hybrid_problems import chain_dataset, chain_modes
from tests.pages import SOURCE

FIGURES = {
    "mac": MAC,
    "comac": COORDINATE_MAC,
    "stabilisation": STABILISATION,
    "spectra": SPECTRA,
    "backbones": BACKBONES,
}
NUMBERS = {COMPARISON, COMPARISON_TABLE, COMPARISON_ROWS}


@pytest.fixture(scope="module")
def found() -> DatasetComparison:
    dataset = chain_dataset(chain_modes(), noise=0.005, realisations=1, samples=500)
    return compare_dataset(replace(dataset, recordings=dataset.recordings[:1]))


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()} - {LIST_FILE}


def test_the_page_shows_what_was_drawn_for_the_files(
    found: DatasetComparison, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sheets = save_comparison(found, tmp_path)
    assert sheets.keys() == set(FIGURES.values())
    assert names(tmp_path) == NUMBERS | sheets.keys()

    def another(*arguments: Any, **options: Any) -> NoReturn:
        raise AssertionError("drawn again")

    monkeypatch.setattr(matplotlib.figure, "Figure", another)
    page = rendered(comparison_page(found, SOURCE, sheets))
    for name, file in FIGURES.items():
        assert drawn(sheets[file], name, "", "").svg in page


def test_a_picture_that_fails_costs_no_numbers(
    found: DatasetComparison, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*arguments: object) -> NoReturn:
        raise ZeroDivisionError

    monkeypatch.setattr(comparison_files, "draw_spectra", failing)
    with pytest.raises(ZeroDivisionError) as caught:
        save_comparison(found, tmp_path)
    assert f"those written before are whole ({', '.join(sorted(NUMBERS))})" in str(caught.value.__notes__)
    assert names(tmp_path) == NUMBERS
