"""A fleet under load: many chains and bridges diagnosed by the command, which is killed at random and begun again.

    python -m benchmarks.fleet_load --out runs/fleet_load                              # 50 chains, 10 bridges, 5 kills
    python -m benchmarks.fleet_load --out runs/few --chains 3 --bridges 0 --kills 2    # a quarter of an hour at most

Printed: whether every dataset has one answer and none was diagnosed again after it had one, the minutes, and the
largest memory of one process and of all together, in each third of the time. Exit status 1 where something is lost.
"""

import argparse
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.files.dataset_file import save_dataset
from fe_models.progress import progress_bar

KINDS = ("added_mass", "stiffness_change", "support_spring")
COMMAND = "from hybrid.commands.app import app; app()"
TICK = 0.25  # s, between two looks at the processes
GIB = 2**20  # KiB


@dataclass(frozen=True)
class Load:
    """How many ``chains`` and ``bridges``, with kinds hidden by turns, ``kills`` and ``jobs``, and the first seed."""

    chains: int = 50
    bridges: int = 10
    kills: int = 5
    jobs: int = 2
    seed: int = 1_800_000


@dataclass(frozen=True)
class Look:
    """The memory of the ``largest`` process and of ``all`` together (KiB) at a ``moment`` (s)."""

    moment: float
    largest: int
    all: int


@dataclass(frozen=True)
class Endured:
    """What a fleet went through: its ``looks``, how many answers each run had when it was killed (``killed_after``),
    the names that were ``lost``, and those diagnosed ``again`` although they had an answer.
    """

    looks: tuple[Look, ...]
    killed_after: tuple[int, ...]
    lost: tuple[str, ...]
    again: tuple[str, ...]


def datasets(load: Load, folder: Path) -> list[str]:
    """Write the datasets; return their names."""
    chain = [
        BlindConfig((KINDS[n % len(KINDS)],), size=0.8, train=3, test=1, duration=20.0) for n in range(load.chains)
    ]
    bridge = [BlindConfig((KINDS[n % 2],), structure="bridge", rich=False) for n in range(load.bridges)]
    names = list[str]()
    with progress_bar("Datasets", load.chains + load.bridges, "dataset") as bar:
        for number, config in enumerate([*chain, *bridge]):
            names.append(f"{config.structure}_{number:02d}")
            save_dataset(blind_case(load.seed + number, config).dataset, folder / names[-1])
            bar.update()
    return names


def endured(load: Load, folder: Path, out: Path, names: list[str]) -> Endured:
    """Diagnose the datasets in ``folder``, killed at random and begun again, until all are done."""
    rng, looks, killed = np.random.default_rng(load.seed), list[Look](), list[int]()
    first = dict[str, int]()  # when each answer was written, as its file says
    again = set[str]()
    share = max(len(names) // (load.kills + 1), 1)
    with progress_bar("Diagnoses", len(names), "dataset") as bar:
        for kill in range(load.kills + 1):
            enough = len(first) + int(rng.integers(1, share + 1)) if kill < load.kills else len(names) + 1
            with _command(load, folder, out) as run:
                late = float(rng.uniform(0, 5))  # s after the last answer that it may give: amid the next ones
                while run.poll() is None and (len(first) < enough or late > 0):
                    time.sleep(TICK)
                    late -= TICK if len(first) >= enough else 0.0
                    looks.append(_look(run.pid))
                    again |= _noted(out, first)
                    bar.update(len(first) - bar.n)
                if run.poll() is None:
                    run.kill()
                    killed.append(len(first))
    again |= _noted(out, first)
    return Endured(tuple(looks), tuple(killed), tuple(sorted(set(names) - first.keys())), tuple(sorted(again)))


def thirds(looks: tuple[Look, ...]) -> Iterator[tuple[float, float]]:
    """Yield the largest memory (GiB) of one process, and of all together, in each third of the time."""
    for part in np.array_split(np.array([(look.largest, look.all) for look in looks]).reshape(-1, 2), 3):
        largest, together = part.max(axis=0, initial=0)
        yield largest / GIB, together / GIB


def _noted(out: Path, first: dict[str, int]) -> set[str]:
    """Note which datasets have an answer; return those whose answer is another than that which was noted."""
    again = set[str]()
    for report in out.glob("*/report.json"):
        row = out / ".fleet" / f"{report.parent.name}.json"
        if not row.is_file():
            continue
        written = report.stat().st_mtime_ns
        if first.setdefault(report.parent.name, written) != written:
            again.add(report.parent.name)
    return again


def _command(load: Load, folder: Path, out: Path) -> "subprocess.Popen[bytes]":
    words = ["diagnose", str(folder), "--out", str(out), "--jobs", str(load.jobs), "--quiet"]
    return subprocess.Popen([sys.executable, "-c", COMMAND, *words], stdout=subprocess.DEVNULL)


def _look(root: int) -> Look:
    """Return the memory of a process and of all that it began."""
    listed = subprocess.run(["ps", "-A", "-o", "pid=,ppid=,rss="], capture_output=True, text=True, check=True).stdout
    rows = [tuple(map(int, line.split())) for line in listed.splitlines()]
    family = {root}
    for _ in range(3):  # a process, its children and theirs
        family |= {pid for pid, parent, _ in rows if parent in family}
    sizes = [size for pid, _, size in rows if pid in family]
    return Look(time.monotonic(), max(sizes, default=0), sum(sizes))


def _read(arguments: list[str] | None) -> tuple[Load, Path]:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    for name in ("chains", "bridges", "kills", "jobs", "seed"):
        parser.add_argument(f"--{name}", type=int, default=getattr(Load, name))
    given = parser.parse_args(arguments)
    return Load(given.chains, given.bridges, given.kills, given.jobs, given.seed), given.out


def main(arguments: list[str] | None = None) -> int:
    """Run the load and print what came of it; return the exit status."""
    load, out = _read(arguments)
    begun = time.monotonic()
    names = datasets(load, out / "datasets")
    found = endured(load, out / "datasets", out / "diagnoses", names)
    print(
        f"{len(names)} datasets, {load.jobs} at a time, killed after {', '.join(map(str, found.killed_after))} answers"
    )
    print(f"lost: {', '.join(found.lost) or 'none'}; diagnosed again: {', '.join(found.again) or 'none'}")
    for number, (largest, together) in enumerate(thirds(found.looks), start=1):
        print(f"third {number} of the time: largest process {largest:.2f} GiB, all together {together:.2f} GiB")
    print(f"{(time.monotonic() - begun) / 60:.1f} minutes")
    return 1 if found.lost or found.again else 0


if __name__ == "__main__":
    sys.exit(main())
