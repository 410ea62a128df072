"""Diagnose the real bridge: its recordings compared, then each of one structure in turn kept for the test."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from fe_models.errors import noting, raise_faults
from fe_models.files.bridge_recordings import RECORDINGS, write_bridge_dataset
from fe_models.files.dataset_file import load_dataset
from fe_models.progress import stage_bar
from hybrid.commands.console import command_line, new_app, say
from hybrid.diagnosis.answer import answer_in_words
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.report_files import save_diagnosis
from hybrid.diagnosis.stage_names import STAGE_NAMES
from hybrid.identification.comparison_files import save_comparison
from hybrid.identification.dataset_comparison import compare_dataset
from hybrid.report.diagnosis_page import page_from_files
from hybrid.report.page_files import save_page
from hybrid.result_sets import comparison_in, diagnosis_in

ANOTHER = 2  # the recording of another structure, as the comparison shows
ALIKE = tuple(number for number in RECORDINGS if number != ANOTHER)

app = new_app()


@app.command()
def main(
    data: Annotated[Path, typer.Argument(help="Folder with the authors' acc_measured1.mat to acc_measured4.mat.")],
    out: Annotated[Path, typer.Option(help="Folder for all results.")] = Path("runs/bridge_diagnosis"),
    tests: Annotated[
        list[int] | None, typer.Option("--test", help="Recordings to test on, one a diagnosis; left out: 1, 3 and 4.")
    ] = None,
) -> None:
    """Compare the four recordings of the real bridge, then diagnose the nominal bridge; A2 is never fitted.

    The recording of another structure, r2, is always among those for training: what it is, a diagnosis says. One takes
    minutes.

    \b
    OUT/comparison            comparison.txt, backbones.png, spectra.png
    OUT/test_r1 (r3, r4)      report.html, report.json, summary.txt, extended_model.toml, modes.png, what_is_wrong.png
    """
    with command_line(quiet=False):
        chosen, faults = tests or ALIKE, list[str]()
        noting(faults, "--out", comparison_in(out / "comparison").check)
        for test in chosen:
            noting(faults, "--out", diagnosis_in(out / f"test_r{test}").check)
        raise_faults(faults)
        everything = load_dataset(write_bridge_dataset(data, out / "comparison", ALIKE[0]))
        compared = compare_dataset(everything)
        save_comparison(compared, out / "comparison")
        print(compared.text)
        for test in chosen:
            folder = out / f"test_r{test}"
            file = write_bridge_dataset(data, folder, test)
            dataset = load_dataset(file)
            with stage_bar(STAGE_NAMES) as begin:
                found = diagnose(dataset, begin)
            say(save_diagnosis(found, folder))
            given = ["hybrid-modal", "diagnose", str(file), "--out", str(folder)]
            say(save_page(diagnosis_in(folder), partial(page_from_files, found, dataset, given, file)))
            print(f"\nTest r{test}, A2 held out\n\n{answer_in_words(found)}")
        print(f"Results: {out}")


if __name__ == "__main__":
    app()
