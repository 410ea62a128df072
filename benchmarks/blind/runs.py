"""Blind cases run under a progress bar, written, drawn and printed."""

from dataclasses import asdict
from pathlib import Path

from benchmarks.blind import figures, grid, summary
from benchmarks.blind.cases import BlindResult, Task, all_done
from benchmarks.blind.confusion import confusion
from benchmarks.blind.reliability import calibration
from fe_models.files.atomic import write_json
from fe_models.progress import progress_bar


def run_blind(wanted: list[Task], peers: tuple[str, ...], jobs: int, out: Path) -> None:
    """Diagnose blind cases; print and draw how right that was. What is at hand is written after each case."""
    config = wanted[0].config
    with progress_bar("Blind cases", len(wanted), "case") as bar:

        def finished(found: list[BlindResult]) -> None:
            bar.update()
            if not found[-1].judgement.first:
                bar.write(found[-1].line)
            write_json(out / "blind.json", summary.content(found, config))

        results = all_done(wanted, peers, jobs, finished)
    write_json(out / "blind.json", summary.content(results, config))
    figures.draw_confusion(confusion(results)).save(out / "blind_confusion.png")
    figures.draw_calibration(calibration(results)).save(out / "blind_calibration.png")
    print(summary.text(results, config))
    print(f"Results: {out}")


def run_rates(wanted: list[Task], jobs: int, out: Path) -> None:
    """Diagnose cases of every noise and size; print and draw how the rates fall."""
    with progress_bar("Noise and size", len(wanted), "case") as bar:
        results = all_done(wanted, (), jobs, lambda _: bar.update())
    cells = grid.cells(results)
    cases = [summary.case_content(result) for result in results]
    write_json(out / "blind_rates.json", {"schema": 1, "cells": [asdict(cell) for cell in cells], "cases": cases})
    figures.draw_grid(cells).save(out / "blind_rates.png")
    print(grid.table(cells))
    print(f"Results: {out}")
