"""Reports to look at: small structures, each with something hidden, through the same commands as a user's."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from scripts.documentation.pages import DOCS, ROOT

PICTURES = ("what_is_wrong.png", "modes.png", "mac.png", "curves.png", "metrics.png")
PORTAL, BUILT = "portal.toml", "as_built.toml"
MASS = '\n[[effects]]\nkind = "added_mass"\nnode = 3\nmass = 15.0\n'  # that the tutorial hides


@dataclass(frozen=True)
class Shown:
    """A report: its ``name``, a ``title``, what was hidden and is to be looked at, ``words``; ``commands`` of
    `hybrid-modal` that make it, the last into the folder ``report``.
    """

    name: str
    title: str
    words: str
    commands: tuple[str, ...]


PULLED = "--pull 3:y:-200 --pull 2:x:100+3:y:-100 --pull 4:x:60+3:y:-150 --duration 10 --no-pictures"
SENSORS = "--sensor 2:x --sensor 3:y --sensor 4:x"
GALLERY = (
    Shown(
        "chain",
        "A spring that stiffens",
        "The four masses of the paper, with a cubic spring at the first that the simulation lacks.",
        (
            "simulate four_dof --out data --cubic-stiffness 0.5 --realisations 12 --no-pictures",
            "diagnose data/dataset.toml --out report",
        ),
    ),
    Shown(
        "portal",
        "A portal with a mass too many",
        "The portal of the tutorial: somebody hung 15 kg at midspan. Nominal values are exact.",
        (
            f"simulate {BUILT} --out data {PULLED} {SENSORS} --sensor 3:x:acceleration:held_out",
            "diagnose data/dataset.toml --out report",
        ),
    ),
    Shown(
        "blind",
        "Too few sensors",
        "The same portal, with the two sensors on its columns alone. What they cannot tell apart is said.",
        (
            f"simulate {BUILT} --out data {PULLED} --sensor 2:x --sensor 4:x",
            "diagnose data/dataset.toml --out report",
        ),
    ),
    Shown(
        "compared",
        "What recordings show by themselves",
        "Recordings of the portal as it is built, beside the drawing: modes, MAC, what changed, how linear it is.",
        (
            f"simulate {BUILT} --out data {PULLED} {SENSORS}",
            "compare data/dataset.toml --out report",
        ),
    ),
    Shown(
        "trained",
        "The motion of the whole structure",
        "The hybrid model of the four masses, learned from four channels, and the motion that it forecasts for all.",
        (
            "simulate four_dof --out data --cubic-stiffness 0.5 --realisations 12 --no-pictures",
            "train data/dataset.toml --out report --preset places --epochs 2",
        ),
    ),
)


def write_gallery(folder: Path, names: tuple[str, ...]) -> None:
    """Make the reports of these ``names``, all without any, and the page ``folder``/gallery.md that leads to them."""
    parts = ["# Gallery", "Reports as the commands wrote them. Each is one file: open it, save it, send it on."]
    for shown in GALLERY:
        if names and shown.name not in names:
            continue
        work = folder / "gallery" / shown.name
        work.mkdir(parents=True)
        _made(shown, work)
        pictures = [path.name for name in PICTURES if (path := work / name).exists()]
        parts.append(f"## {shown.title}")
        parts.append(f"{shown.words} **[Open the report](gallery/{shown.name}/report.html)**")
        parts.append("\n".join(["```sh", *(f"hybrid-modal {command}" for command in shown.commands), "```"]))
        parts += [f"![{shown.title}](gallery/{shown.name}/{name})" for name in pictures[:1]]
    parts.append("The portal, and how a report is read: [tutorial](tutorial.md), [the page](report_page.md).")
    (folder / "gallery.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def _made(shown: Shown, folder: Path) -> None:
    """Run the commands in a folder of their own, and keep the report and its pictures."""
    work = folder / "work"
    work.mkdir()
    tutorial = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    portal = tutorial.split(f"```toml file={PORTAL}\n")[1].split("```")[0]
    (work / PORTAL).write_text(portal, encoding="utf-8")
    (work / BUILT).write_text(portal + MASS, encoding="utf-8")
    for command in shown.commands:
        run(["-c", "from hybrid.commands.app import app; app()", *command.split(), "--quiet"], work)
        if command.startswith(f"simulate {BUILT}"):
            _held_against_drawing(work / "data" / "dataset.toml")
    for name in ("report.html", *PICTURES):
        if (work / "report" / name).exists():
            shutil.copy(work / "report" / name, folder / name)
    shutil.rmtree(work)


def _held_against_drawing(dataset: Path) -> None:
    """Forget what was built: the recordings are of the drawing, as far as anybody knows."""
    lines = dataset.read_text(encoding="utf-8").splitlines()
    own = [f'model = "../{PORTAL}"' if line.startswith("model = ") else line for line in lines]
    dataset.write_text("\n".join(own) + "\n", encoding="utf-8")


def run(words: list[str], folder: Path, **more: str) -> None:
    """Run Python with these ``words`` in a folder; `RuntimeError` with what it said where it fails."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), **more}
    done = subprocess.run(
        [sys.executable, *words], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(f"{' '.join(words)} failed in {folder}:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
