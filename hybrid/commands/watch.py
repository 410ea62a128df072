"""The sub-command `watch`: new recordings of a structure held against its history, an alarm when its state changes."""

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from hybrid.commands.console import command_line
from hybrid.commands.options import Out, Quiet

if TYPE_CHECKING:
    from hybrid.monitoring.observation import Kept
    from hybrid.monitoring.watching import Watch

ALARM_STATUS = 3  # exit status with --once where a recording that is new raises an alarm

Folder = Annotated[Path, typer.Argument(help="The folder into which recordings come.", show_default=False)]
DatasetOption = Annotated[
    Path | None,
    typer.Option(help="The dataset file that says how recordings are read. [default: FOLDER/dataset.toml]"),
]
Once = Annotated[bool, typer.Option("--once", help="Look once, and end: for a job that a clock starts, cron say.")]
Every = Annotated[float, typer.Option(min=1.0, max=86400.0, help="Time between two looks at the folder, s.")]
Settled = Annotated[
    float,
    typer.Option(min=0.0, max=86400.0, help="A file that was written to less than so many s ago is left for later."),
]
History = Annotated[int, typer.Option(min=2, max=1000, help="Recordings that say what is usual, before any is judged.")]
Diagnose = Annotated[
    bool, typer.Option("--diagnose/--no-diagnose", help="Diagnose what changed when an alarm is raised; takes minutes.")
]
Accept = Annotated[
    bool, typer.Option("--accept", help="The alarm is known: recordings since then are a new state with a new history.")
]


def watch(
    folder: Folder,
    out: Out,
    dataset: DatasetOption = None,
    once: Once = False,
    every: Every = 60.0,
    settled: Settled = 10.0,
    history: History = 5,
    diagnose: Diagnose = True,
    accept: Accept = False,
    quiet: Quiet = False,
) -> None:
    """Watch a structure: hold each new recording in FOLDER against its history, and raise an alarm when it changed.

    FOLDER/dataset.toml names model, sensors and the recordings that begin the history; other recordings in FOLDER are
    read like the first of these. Natural frequencies are identified with their standard deviations, followed by shape,
    and have control charts: one each, and Hotelling's T^2 of all together. Limits follow from the scatter of the
    history and from the identification, with one false alarm in 370 recordings. When an alarm is raised the recordings
    before and after are diagnosed together: what changed, and where. All is kept on disk; the same command goes on.

    \b
    OUT/watch.html           the charts, what is usual, all recordings
    OUT/watch.json           the same for programs, from which the watch goes on
    OUT/change-NAME/         the diagnosis of the change that recording NAME showed first

    The exit status of --once is 3 where a new recording raises an alarm.

    \b
    Example:
      hybrid-modal watch bridge --out runs/watch --once
      hybrid-modal watch bridge --out runs/watch --every 600
    """
    from hybrid.monitoring.observation import STATE_FILE, load_kept, save_kept
    from hybrid.monitoring.station import load_station
    from hybrid.monitoring.watching import Watch, accepted, diagnose_change, new_alarms
    from hybrid.result_sets import watch_in

    status = 0
    with command_line(quiet) as result:
        watch_in(out).check()
        station = load_station(folder, dataset, has_begun=(out / STATE_FILE).exists())
        watched = Watch(station, out, history, diagnose=diagnose_change if diagnose else None)
        kept = load_kept(out, station.digests)
        if accept:
            kept = accepted(kept)
            save_kept(out, kept)
        shown = None  # what the page shows
        while True:
            before = kept
            kept = _look(watched, kept, settled)
            if kept != shown:
                _write_page(watched, kept)
                shown = kept
            alarms = new_alarms(before.observations, kept.observations)
            if alarms:
                print(f"ALARM: {', '.join(own.name for own in alarms)}; see {out / 'watch.html'}", file=sys.stderr)
            if once:
                status = ALARM_STATUS if alarms else 0
                break
            time.sleep(every)
        print(f"Results: {out / 'watch.html'}")
        result(out / "watch.html")
    if status:
        raise SystemExit(status)


def _look(watched: "Watch", kept: "Kept", settled: float) -> "Kept":
    """Look at all recordings that are new, and say what they show."""
    from fe_models.progress import progress_bar
    from hybrid.monitoring.page import words_of

    new = watched.missing(kept, settled, time.time())
    with progress_bar("Recordings", len(new), "recording") as bar:
        for own in new:
            kept = watched.looked_at(kept, own)
            bar.write("\n".join(words_of(kept.observations[-1])))
            bar.update()
    return watched.diagnosed(kept)


def _write_page(watched: "Watch", kept: "Kept") -> None:
    from fe_models.files.atomic import write_text
    from hybrid.monitoring.page import standing_of, watch_page
    from hybrid.report.rendering import rendered
    from hybrid.result_sets import WATCH_PAGE, watch_in

    page = watch_page(kept, watched.station.folder.name, watched.least_history)
    with watch_in(watched.out).replacing() as new:
        write_text(new / WATCH_PAGE, rendered(page))
    print(standing_of(kept, watched.least_history)[2])
