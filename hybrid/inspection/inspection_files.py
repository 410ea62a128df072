"""What an inspection leaves in its folder."""

import os
from pathlib import Path

from fe_models.files.atomic import write_json, write_text
from fe_models.files.result_set import ResultSet
from hybrid.inspection.inspection import Inspection
from hybrid.inspection.inspection_report import as_json, describe, draw
from hybrid.inspection.starter_dataset import starter_dataset

DATASET, SUMMARY, NUMBERS, PICTURE = "dataset.toml", "inspection.txt", "inspection.json", "inspection.png"


def inspection_in(folder: Path) -> ResultSet:
    """Return what an inspection leaves in ``folder``."""
    return ResultSet(folder, "inspect", (DATASET, SUMMARY, NUMBERS, PICTURE))


def save_inspection(found: Inspection, folder: Path) -> Path:
    """Write all files of an inspection; return the path of the dataset to start from."""
    results = inspection_in(folder)
    beside = os.path.relpath(found.signals.path.resolve(), folder.resolve())
    with results.replacing() as new:
        write_text(new / DATASET, starter_dataset(found.signals, found.facts, found.guess, Path(beside).as_posix()))
        write_text(new / SUMMARY, describe(found) + "\n")
        write_json(new / NUMBERS, as_json(found))
        draw(found).save(new / PICTURE)
    return folder / DATASET
