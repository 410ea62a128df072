"""Build the documentation's site, warnings being errors: pages, reference, notebooks, gallery."""

import shutil
from pathlib import Path
from typing import Annotated

import typer

from scripts.documentation.gallery import run, write_gallery
from scripts.documentation.notebooks import write_notebooks
from scripts.documentation.pages import ROOT, write_pages

app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def main(
    out: Annotated[Path, typer.Option(help="Folder for pages and site, made anew.")] = Path("runs/docs"),
    report: Annotated[list[str] | None, typer.Option(help="Of the gallery: these alone. Repeat.")] = None,
) -> None:
    """Write the pages into OUT/pages and the site into OUT/site; OUT/site/index.html is where to begin.

    It takes some minutes: the reports of the gallery are made by the commands that they show. Needs the packages of
    the extra `docs`.
    """
    pages, site = (out / "pages").absolute(), (out / "site").absolute()
    for folder in (pages, site):
        shutil.rmtree(folder, ignore_errors=True)
    write_pages(pages)
    write_notebooks(pages / "notebooks")
    write_gallery(pages, tuple(report or ()))
    words = ["-m", "mkdocs", "build", "--strict", "--quiet", "--config-file", str(ROOT / "mkdocs.yml")]
    run(words, ROOT, PAGES=str(pages), SITE=str(site), NO_MKDOCS_2_WARNING="1")
    print(f"Documentation: {site / 'index.html'}")


if __name__ == "__main__":
    app()
