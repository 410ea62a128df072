"""A blind case as files: the dataset, which a diagnosis reads, and the truth beside it, which it does not."""

from dataclasses import asdict
from pathlib import Path

from benchmarks.blind_cases.case import BlindCase
from fe_models.files.atomic import write_json
from fe_models.files.dataset_file import save_dataset
from fe_models.structure import Structure


def save_case(case: BlindCase, folder: Path) -> Path:
    """Write ``dataset.toml`` with its recordings and ``truth.json`` into ``folder``; return the dataset's path.

    truth.json lists kind, location, parameters and their units of each ``cause`` in the words of a report, what is
    hidden from ``outside`` of the list, the ``recordings`` where they act, and the ``factors`` of groups that are far
    from their drawing.
    """
    assert isinstance(case.dataset.model, Structure)  # a blind case has a built-in structure, known by its name
    folder.mkdir(parents=True, exist_ok=True)
    truth = [
        {"kind": cause.kind, "location": cause.location, "parameters": cause.parameters, "units": cause.units}
        for cause in case.truth
    ]
    document = {
        "schema": 1,
        "causes": truth,
        "outside": list(case.outside),
        "recordings": list(case.recordings),
        "factors": [asdict(factor) for factor in case.factors],
    }
    write_json(folder / "truth.json", document)
    return save_dataset(case.dataset, folder, case.dataset.model.name)
