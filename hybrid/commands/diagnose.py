"""The sub-command `diagnose`: name what a simulation gets wrong, extend the model, measure the gain."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fe_models.errors import raise_faults
from hybrid.commands.console import command_line, print_notes, say, words_of
from hybrid.commands.options import Out, Quiet

if TYPE_CHECKING:
    from hybrid.fleet.diagnosed_file import Options

Hybrid = Annotated[
    bool,
    typer.Option(
        "--hybrid", help="Also train the hybrid model on the nominal and on the extended structure; takes minutes."
    ),
]
ByModes = Annotated[
    bool,
    typer.Option(
        "--by-modes",
        help="Go by natural frequencies, damping ratios, mode shapes and motion in any case: for a structure that may"
        " be far from its drawing. Without it a first look at the modes decides.",
    ),
]
OlderByModes = Annotated[bool, typer.Option("--modes", hidden=True)]  # a number of modes in other commands
Jobs = Annotated[
    int | None,
    typer.Option(
        min=1, help="Of several datasets: how many at a time, a process of one thread each. [default: one a core]"
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(help="Of several datasets: have the workers of this Dask scheduler do them, such as tcp://HOST:8786."),
]
Datasets = Annotated[
    list[Path],
    typer.Argument(help="The dataset's TOML file; or several, or folders in which they are.", show_default=False),
]


def diagnose(
    dataset: Datasets,
    out: Out,
    hybrid: Hybrid = False,
    by_modes: ByModes = False,
    modes: OlderByModes = False,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
    quiet: Quiet = False,
) -> None:
    """Diagnose a chain, a frame or matrices by groups from recordings.

    All causes on the list compete at all their places. What is found is built into the structure, and forecasts of the
    test recordings are scored before and after. A modal model that the dataset states is compared with the structure's
    own modes. The exit status is 0 once a report is written, whatever its verdict.

    A structure that is nearly right as drawn is compared with every sample. Where a first look shows that it is not,
    or that it changed between recordings, the evidence is natural frequencies, damping ratios and mode shapes, and how
    the motion departs from these modes: that tells how far groups of elements are off, what changed, and which force
    law acts. Recordings of wind and traffic, identified modes ([[modes]]) and matrices by groups are diagnosed so, too.

    \b
    OUT/report.html          all of it on a page for a browser, whole in one file: read this first
    OUT/report.json          verdict, findings with probabilities and alternatives, scores
    OUT/summary.txt          the same in words, as printed
    OUT/extended_model.toml  the structure with the findings, a model for the other commands
    OUT/what_is_wrong.png    a test recording beside both models' forecasts, and the spectra of their errors
    OUT/modes.png            measured modes beside the structure's, where these were the evidence
    OUT/fleet.html, .json    of several datasets: the table of all answers; their files are in OUT/NAME

    Of several datasets, or of a folder of them, each has a folder of its own within OUT, and OUT/fleet.html has all
    answers in one table. After an interruption the same command goes on. A dataset that cannot be diagnosed has its
    error in its row, and the exit status is then 1.

    \b
    Example:
      hybrid-modal diagnose runs/chain/dataset.toml --out runs/chain/diagnosis
      hybrid-modal diagnose bridges --out runs/bridges --jobs 4
    """
    from hybrid.fleet.datasets import is_fleet
    from hybrid.fleet.diagnosed_file import Options

    options = Options(hybrid, by_modes or modes)
    with command_line(quiet) as result:
        if is_fleet(dataset):
            from hybrid.commands.fleet import diagnose_fleet

            status = diagnose_fleet(dataset, out, options, jobs, scheduler)
            result(out / "fleet.html")
        else:
            raise_faults(_of_fleets_alone(jobs=jobs, scheduler=scheduler))
            status = 0
            _diagnose(dataset[0], out, options)
            result(out / "report.json")
    if status:
        raise SystemExit(status)


def _diagnose(dataset: Path, out: Path, options: "Options") -> None:
    from hybrid.fleet.diagnosed_file import diagnosed_file

    words = [*words_of("diagnose", dataset, out), *options.words]
    done = diagnosed_file(dataset, out, options, words, read=print_notes, say=say)
    from hybrid.diagnosis.answer import answer_in_words

    print(f"{answer_in_words(done.found, done.gain)}\n{done.trust.line}")
    print(f"Results: {out}")


def _of_fleets_alone(**given: object) -> list[str]:
    return [
        f"--{name} has no effect on one dataset: it goes with several, or a folder of them"
        for name, value in given.items()
        if value is not None
    ]
