"""Name what a simulation gets wrong: show it, name the cause, extend the model, measure the gain."""

from pathlib import Path
from typing import Annotated

import typer
from tqdm import tqdm

from fe_models.errors import bad_input_exits, noting, raise_faults
from fe_models.files.atomic import check_folder, write_json
from fe_models.files.dataset_file import load_dataset
from fe_models.files.structure_file import save_structure
from fe_models.recordings import Dataset
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.learned.gain import Gain, hybrid_gain
from hybrid.diagnosis.observed.example import draw_example
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.report import describe_diagnosis, report_table

app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def main(
    dataset: Annotated[Path, typer.Argument(help="The dataset's TOML file.")],
    out: Annotated[Path, typer.Option(help="Folder for the results; made where it is missing.")],
    hybrid: Annotated[
        bool,
        typer.Option(
            "--hybrid", help="Also train the hybrid model on the nominal and on the extended structure; takes minutes."
        ),
    ] = False,
) -> None:
    """Diagnose a chain or frame from its recordings.

    All causes of the list compete at all their places. What is found is built into the structure, and forecasts of the
    test recordings are scored before and after. A modal model that the dataset simulates with is held against the
    structure's own modes.

    \b
    OUT/report.json          verdict, findings with probabilities and alternatives, scores
    OUT/extended_model.toml  the structure with the findings, which every script accepts as a model
    OUT/what_is_wrong.png    a test recording beside both models' forecasts, and the spectra of their errors

    \b
    Example:
      python scripts/diagnose.py runs/chain/dataset.toml --out runs/chain/diagnosis
    """
    with bad_input_exits():
        faults = list[str]()
        noting(faults, "--out", check_folder, out)
        data = noting(faults, "", load_dataset, dataset, dead_channels=True)
        raise_faults(faults)
        assert data is not None  # else there were faults
        with tqdm(desc="diagnosis", unit=" steps") as bar:

            def advance(what: str) -> None:
                bar.set_description_str(what)
                bar.update()

            found = diagnose(data, advance)
        save_structure(found.extended, out / "extended_model.toml")
        draw_example(out / "what_is_wrong.png", found.example)
        write_json(out / "report.json", report_table(found))  # now: the training below takes minutes
        gain = _gain(data, found) if hybrid else None
        if gain is not None:
            write_json(out / "report.json", report_table(found, gain))
        print(describe_diagnosis(found, gain))
        print(f"Results: {out}")


def _gain(data: Dataset, found: Diagnosis) -> Gain:
    with tqdm(desc="training hybrid models", unit=" epochs") as bar:
        return hybrid_gain(data, found, advance=bar.update)


if __name__ == "__main__":
    app()
