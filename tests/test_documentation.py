"""The documents: links lead somewhere, the site's menu has every page, commands and options exist, notebooks run."""

import ast
import importlib.util
import json
import re
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

import fe_models as fe
import hybrid
from hybrid.commands.app import main_app
from scripts.documentation import pages
from scripts.documentation.gallery import GALLERY

ROOT = Path(__file__).parents[1]
DOCUMENTS = [*(ROOT / name for name in pages.OF_THE_ROOT), *sorted((ROOT / "docs").rglob("*.md"))]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
LINK = re.compile(r'(?:\]\(|(?:src|href)=")([^)"\s]+)')
CODE = re.compile(r"^```.*?^```$|`[^`\n]*`", re.MULTILINE | re.DOTALL)
BLOCK = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)
COMMAND = re.compile(r"hybrid-modal ([a-z]+)((?: [^`\n|;]+)?)")
OPTION = re.compile(r"(?<!\S)(--[a-z][a-z-]*)")


def anchors_of(text: str) -> set[str]:
    """Return the anchors that GitHub gives the headings of a page."""
    headings = HEADING.findall(BLOCK.sub("", text))
    words = (re.sub(r"[^\w\- ]", "", heading.lower()) for heading in headings)
    return {word.replace(" ", "-") for word in words}


def broken_links(text: str, folder: Path) -> list[str]:
    """Return the links of a page in a ``folder`` that lead to no file, or to no heading of one."""
    broken = []
    for target in LINK.findall(CODE.sub("", text)):
        name, _, anchor = target.partition("#")
        path = folder / name if name else None
        if re.match(r"[a-z]+:", target):
            continue
        if (path is not None and not path.is_file()) or (
            anchor and anchor not in anchors_of(text if path is None else path.read_text(encoding="utf-8"))
        ):
            broken.append(target)
    return broken


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_to_files_and_headings(path: Path) -> None:
    assert broken_links(path.read_text(encoding="utf-8"), path.parent) == []


def test_a_broken_link_is_seen() -> None:
    text = "# A heading\n[a](limits.md) [b](no.md) [c](limits.md#none) [d](#a-heading) [e](#else) `[f](no.md)`"
    assert broken_links(text, ROOT / "docs") == ["no.md", "limits.md#none", "#else"]


def test_the_menu_of_the_site_has_every_page_once() -> None:
    menu = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").split("\nnav:")[1]
    named = re.findall(r"(\S+\.md)$", menu, re.MULTILINE)
    made = {*pages.OF_THE_ROOT.values(), "gallery.md", *(f"reference/{name}.md" for name in pages.PACKAGES)}
    written = {path.relative_to(ROOT / "docs").as_posix() for path in (ROOT / "docs").rglob("*.md")}
    run = {f"notebooks/{path.stem}.md" for path in NOTEBOOKS}
    assert sorted(named) == sorted(made | written | run)


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.name)
def test_commands_and_options_that_are_shown_exist(path: Path) -> None:
    check_commands(path.read_text(encoding="utf-8"))


def test_commands_of_the_gallery_exist() -> None:
    check_commands("\n".join(f"hybrid-modal {command}" for shown in GALLERY for command in shown.commands))
    with pytest.raises(AssertionError, match="--nothing"):
        check_commands("hybrid-modal diagnose a.toml --nothing")


def check_commands(text: str) -> None:
    """Fail where a text shows a sub-command, or an option of one, that does not exist."""
    group: Any = get_command(main_app())
    for name, rest in COMMAND.findall(text):
        assert name in group.commands
        options = {option for own in group.commands[name].params for option in (*own.opts, *own.secondary_opts)}
        unknown = set(OPTION.findall(rest)) - options - {"--help"}
        assert not unknown, f"{name}: {unknown}"


def test_pages_of_the_root_link_from_where_they_go() -> None:
    text = '[a](docs/api.md) [b](CONTRIBUTING.md#rules) <img src="docs/demo.png"> [c](https://a.b/docs/c.md)'
    moved = pages.LINK.sub(pages._from_root, text)
    assert moved == '[a](api.md) [b](contributing.md#rules) <img src="demo.png"> [c](https://a.b/docs/c.md)'


def test_the_reference_has_all_that_is_exported() -> None:
    for package in (fe, hybrid):
        named = re.findall(r"^::: (\S+)$", pages.reference(package.__name__), re.MULTILINE)
        assert named == [f"{package.__name__}.{name}" for name in package.__all__]


def test_formulas_stand_as_github_and_browsers_take_them() -> None:
    pytest.importorskip("latex2mathml", reason="needs the extra `docs`")
    text = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
    made = pages.with_formulas(text)
    formulas = made.count("<math")
    assert formulas == text.count("```math") + text.count("$`") > 20
    assert "$`" not in made and "```math" not in made
    shown = re.sub(r"<[^>]*>", "", " ".join(re.findall(r"<math.*?</math>", made, re.DOTALL)))
    assert not set("\\&") & set(unescape(shown))  # a command, or an environment, that is not known stands as it is


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_hold_no_outputs(path: Path) -> None:
    """What is printed follows from the code, and is printed anew when the site is built."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    assert all(not cell["outputs"] and cell["execution_count"] is None for cell in cells if cell["cell_type"] == "code")


def run_notebook(path: Path) -> dict[str, object]:
    """Return the names that a notebook's code leaves, cell by cell; what ends a cell is shown as a notebook does."""
    names: dict[str, object] = {}
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] != "code":
            continue
        *body, last = ast.parse("".join(cell["source"])).body
        exec(compile(ast.Module(body, []), path.name, "exec"), names)
        if isinstance(last, ast.Expr):
            shown = eval(compile(ast.Expression(last.value), path.name, "eval"), names)
            assert getattr(shown, "_repr_html_", shown.__repr__)()
        else:
            exec(compile(ast.Module([last], []), path.name, "exec"), names)
    return names


@pytest.mark.parametrize(
    ("name", "element", "factor"),
    [
        pytest.param("from_structure_to_diagnosis", 3, 0.7, marks=pytest.mark.slow),
        ("modes_of_own_recordings", 2, 0.8),
    ],
)
def test_notebooks_find_what_they_hide(name: str, element: int, factor: float) -> None:
    report = run_notebook(ROOT / "docs" / "notebooks" / f"{name}.ipynb")["report"]
    assert isinstance(report, hybrid.Report)
    finding = report.findings[0]
    assert (finding.cause.kind, finding.cause.location) == ("stiffness_change", {"element": element})
    found = finding.parameters["factor"]
    assert abs(found.value - factor) < 4 * found.std  # one in 16,000 lies further off by chance
    assert finding.probability > 0.5


class Loaded(HTMLParser):
    """What a page loads from elsewhere."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        own = dict(attrs)
        address = own.get("src") or (own.get("href") if tag == "link" and own.get("rel") == "stylesheet" else None)
        if address and re.match(r"(https?:)?//", address):
            self.found.append(address)


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("mkdocs") is None, reason="needs the extra `docs`: make docs")
def test_the_site_is_built_without_a_warning_and_loads_nothing(tmp_path: Path) -> None:
    """All of it but for the longer reports of the gallery."""
    from scripts.documentation.gallery import run

    run(["-m", "scripts.build_docs", "--out", str(tmp_path), "--report", "chain"], ROOT)
    site = tmp_path / "site"
    assert (site / "gallery" / "chain" / "report.html").stat().st_size > 10_000
    reference = (site / "reference" / "hybrid.html").read_text(encoding="utf-8")
    assert 'id="hybrid.diagnose"' in reference
    notebook = (site / "notebooks" / "from_structure_to_diagnosis.html").read_text(encoding="utf-8")
    assert "times its nominal stiffness" in notebook  # as the answer is printed
    for path in site.rglob("*.html"):
        assert Loaded(path.read_text(encoding="utf-8")).found == [], path
