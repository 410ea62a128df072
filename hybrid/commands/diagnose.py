"""The sub-command `diagnose`: name what a simulation gets wrong, extend the model, measure the gain."""

from typing import Annotated

import typer

from hybrid.commands.options import DatasetFile, Out

Hybrid = Annotated[
    bool,
    typer.Option(
        "--hybrid", help="Also train the hybrid model on the nominal and on the extended structure; takes minutes."
    ),
]


def diagnose(dataset: DatasetFile, out: Out, hybrid: Hybrid = False) -> None:
    """Diagnose a chain or frame from its recordings.

    All causes of the list compete at all their places. What is found is built into the structure, and forecasts of the
    test recordings are scored before and after. A modal model that the dataset simulates with is held against the
    structure's own modes.

    \b
    OUT/report.json          verdict, findings with probabilities and alternatives, scores
    OUT/extended_model.toml  the structure with the findings, which every command accepts as a model
    OUT/what_is_wrong.png    a test recording beside both models' forecasts, and the spectra of their errors

    \b
    Example:
      hybrid-modal diagnose runs/chain/dataset.toml --out runs/chain/diagnosis
    """
    from tqdm import tqdm

    from fe_models.errors import bad_input_exits, noting, raise_faults
    from fe_models.files.atomic import check_folder, write_json
    from fe_models.files.dataset_file import load_dataset
    from fe_models.files.structure_file import save_structure

    with bad_input_exits():
        faults = list[str]()
        noting(faults, "--out", check_folder, out)
        data = noting(faults, "", load_dataset, dataset, dead_channels=True)
        raise_faults(faults)
        assert data is not None  # else there were faults
        from hybrid.diagnosis import diagnosis  # only now: it takes longer to load than a mistake to be told
        from hybrid.diagnosis.observed.example import draw_example
        from hybrid.diagnosis.report import describe_diagnosis, report_table

        with tqdm(desc="diagnosis", unit=" steps") as bar:

            def advance(what: str) -> None:
                bar.set_description_str(what)
                bar.update()

            found = diagnosis.diagnose(data, advance)
        save_structure(found.extended, out / "extended_model.toml")
        draw_example(out / "what_is_wrong.png", found.example)
        write_json(out / "report.json", report_table(found))  # now: the training below takes minutes
        gain = None
        if hybrid:
            from hybrid.diagnosis.learned.gain import hybrid_gain

            with tqdm(desc="training hybrid models", unit=" epochs") as bar:
                gain = hybrid_gain(data, found, advance=bar.update)
            write_json(out / "report.json", report_table(found, gain))
        print(describe_diagnosis(found, gain))
        print(f"Results: {out}")
