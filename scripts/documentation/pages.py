"""The pages of the site: those of docs/, those of the project's root, and a reference of all that is exported."""

import importlib
import re
import shutil
from pathlib import Path

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
OF_THE_ROOT = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
PACKAGES = ("fe_models", "hybrid")
LINK = re.compile(r'(\]\(|src=")([^)"#\s]+)')
FORMULA = re.compile(r"^```math\n(.*?)^```$", re.DOTALL | re.MULTILINE)
IN_LINE = re.compile(r"\$`([^`]+)`\$")
FILE_NAME = re.compile(r"^```toml file=\S+$", re.MULTILINE)


def write_pages(folder: Path) -> None:
    """Write all pages that need no computation into an empty ``folder``."""
    shutil.copytree(DOCS, folder, ignore=shutil.ignore_patterns("*.ipynb", "*.json"))
    for name, page in OF_THE_ROOT.items():
        text = (ROOT / name).read_text(encoding="utf-8")
        (folder / page).write_text(LINK.sub(_from_root, text), encoding="utf-8")
    for path in folder.rglob("*.md"):
        path.write_text(with_formulas(FILE_NAME.sub("```toml", path.read_text(encoding="utf-8"))), encoding="utf-8")
    (folder / "reference").mkdir()
    for package in PACKAGES:
        (folder / "reference" / f"{package}.md").write_text(reference(package), encoding="utf-8")


def _from_root(link: re.Match[str]) -> str:
    """Return a link of a page that moves from the root into docs/."""
    target = OF_THE_ROOT.get(link[2], link[2].removeprefix("docs/"))
    return f"{link[1]}{target}"


def with_formulas(text: str) -> str:
    """Return Markdown with its formulas, LaTeX as GitHub takes it, as MathML: browsers show it without a program."""
    from latex2mathml.converter import convert

    def displayed(found: re.Match[str]) -> str:
        return f"<p>{convert(found[1].strip(), display='block')}</p>"

    return IN_LINE.sub(lambda found: convert(found[1].strip()), FORMULA.sub(displayed, text))


def reference(package: str) -> str:
    """Return the page of all names that a package exports, in their order, by their docstrings."""
    names: list[str] = importlib.import_module(package).__all__
    blocks = "\n\n".join(f"::: {package}.{name}" for name in names)
    about = f"All that `import {package}` gives. What belongs together: [overview](../api.md)."
    return f"# `{package}`\n\n{about}\n\n{blocks}\n"
