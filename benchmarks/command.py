"""The sub-command `benchmark` of `hybrid-modal`: everything that the product is measured against, in one run."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from benchmarks.options import (
    AUDIT,
    BLIND,
    CERTIFICATE,
    SECTIONS,
    AuditOptions,
    BlindOptions,
    CertificateOptions,
    SectionOptions,
)
from hybrid.commands.console import command_line, given_options
from hybrid.commands.option_groups import with_option_groups
from hybrid.commands.options import Quiet

if TYPE_CHECKING:
    from benchmarks.blind_cases import BlindConfig

Out = Annotated[
    Path | None,
    typer.Option(help="Folder for the results. [default: runs/benchmark; with --certificate runs/certificate/COMMIT]"),
]
Seed = Annotated[int, typer.Option(min=0, help="Of the modal model that is drawn, or of the first blind case.")]
Jobs = Annotated[
    int | None,
    typer.Option(
        min=1,
        help="With --blind, --rates or --certificate: processes, one thread each. [default: 1; 2 of a certificate]",
    ),
]


@with_option_groups
def benchmark(
    context: typer.Context,
    out: Out = None,
    seed: Seed = 0,
    jobs: Jobs = None,
    sections: SectionOptions = SECTIONS,
    cases: BlindOptions = BLIND,
    certified: CertificateOptions = CERTIFICATE,
    audited: AuditOptions = AUDIT,
    quiet: Quiet = False,
) -> None:
    """Measure accuracy and time on the paper's chain, the cost of a trajectory, and what each part of the model is for.

    Every number stands beside its peer's, measured in the same run unless marked as published. The authors' own modal
    model of the chain comes with their program; without --modal-model one that is wrong in the same way is drawn.
    Their recordings of the bridge come with it, too: --recordings adds it, about a quarter of an hour in all.

    With --blind, effects are hidden in simulated recordings and diagnosed before the truth is opened;
    beside the diagnosis stand exhaustive selection by AIC and sparse regression (PySINDy).

    With --certificate, 300 blind cases of each chain column and 120 of each bridge column (exact, and off by their
    uncertainty) are diagnosed, and fewer of bridges far from their drawing or changed before one recording, and under
    ambient vibration, known forces and base motion. Each is kept as soon as it is done, so that the same command goes
    on after an interruption. Its seeds are for this alone: what it misses is counted, never looked into.

    With --audit, log evidences in closed form, by modes and by series, are held against nested sampling on 40 fits of
    a small chain, and true values against the posteriors of 200 draws each; --quick does a few. The same command goes
    on after an interruption.

    \b
    OUT/benchmark.json         the table
    OUT/cost.png               seconds and memory against length, batch, modes and sensors
    OUT/blind.json             with --blind: the table, the confusion matrix, the calibration curve, every case
    OUT/blind_confusion.png    which kinds were hidden, which were named first
    OUT/blind_calibration.png  how many of the findings named at a probability are right
    OUT/next.json              with --next: how many open cases the advised measurement resolves, and a random one
    OUT/audit.json             with --audit: every fit, and how even ranks are
    OUT/blind_rates.json, .png with --rates: how the rates fall with noise and size
    OUT/cases/                 with --certificate: what is kept of each case
    docs/certificate.md, .json with --certificate: rates with intervals, probabilities and times, of the clone that runs
    """
    from benchmarks.run_kind import run_kind

    with command_line(quiet) as result:
        run_kind(given_options(context))
        if certified.certificate:
            result(_certificate(out, certified, jobs or 2))
            return
        folder = out or Path("runs/benchmark")
        if audited.audit:
            result(_audit(sections.quick, folder))
        elif cases.blind is not None:
            result(_blind(cases, cases.blind, seed, jobs or 1, folder))
        elif cases.next is not None:
            result(_next(cases.next, seed, folder))
        elif cases.rates is not None:
            result(_rates(cases, cases.rates, seed, jobs or 1, folder))
        else:
            result(_sections(sections, seed, folder))


def _certificate(out: Path | None, given: CertificateOptions, jobs: int) -> Path:
    from benchmarks.certificate.door import certify

    certify(out, jobs, given.minutes, given.dirty)
    return Path("docs/certificate.md")


def _audit(quick: bool, folder: Path) -> Path:
    """Hold evidences against nested sampling, and posteriors against truths."""
    from benchmarks.audit.run import QUICK, WHOLE, run_audit

    run_audit(QUICK if quick else WHOLE, folder)
    return folder / "audit.json"


def _blind(given: BlindOptions, count: int, seed: int, jobs: int, folder: Path) -> Path:
    """Diagnose ``count`` blind cases, one after the other of what is to be hidden."""
    from benchmarks.blind.cases import PEERS, default_words, tasks
    from benchmarks.blind.runs import run_blind

    config = replace(
        _nearness(given),
        noise=given.noise,
        noisy=given.noisy,
        train=given.train,
        test=given.test,
        measured=given.sensors,
        changed=given.changed,
        step=given.step,
    )
    cases = tasks(count, seed, given.kinds.split(",") if given.kinds else default_words(config), config)
    peers = tuple(PEERS) if given.peers and config.excitation == "free" else ()
    run_blind(cases, peers, jobs, folder)
    return folder / "blind.json"


def _next(count: int, seed: int, folder: Path) -> Path:
    """Measure cases again that are left open, until there are ``count`` of them."""
    from benchmarks.next_measurement.run import run_next

    run_next(count, seed, folder)
    return folder / "next.json"


def _rates(given: BlindOptions, count: int, seed: int, jobs: int, folder: Path) -> Path:
    """Diagnose ``count`` blind cases of each noise and size."""
    from benchmarks.blind.cases import NOTHING, default_words
    from benchmarks.blind.grid import grid_tasks
    from benchmarks.blind.runs import run_rates
    from benchmarks.blind_cases import OUTSIDE

    config = _nearness(given)
    inside = [word for word in default_words(config) if word not in (NOTHING, *OUTSIDE)]
    run_rates(grid_tasks(count, seed, given.kinds.split(",") if given.kinds else inside, config), jobs, folder)
    return folder / "blind_rates.json"


def _nearness(given: BlindOptions) -> "BlindConfig":
    """Return which structure is diagnosed, how near its drawing is to the truth, where the effect acts, and what moves
    the structure.
    """
    from benchmarks.blind_cases import BlindConfig

    tier = "off" if given.off else given.tier or "exact"
    return BlindConfig(tier=tier, acts=given.acts, excitation=given.excitation, structure=given.structure)


def _sections(given: SectionOptions, seed: int, folder: Path) -> Path:
    from benchmarks.sections import run_sections

    run_sections(given.only or (), given.modal_model, given.recordings, seed, given.quick, folder)
    return folder / "benchmark.json"
