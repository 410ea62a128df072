"""Notebooks as pages: run from their first cell to the last, then written as Markdown with what they print."""

import re
from pathlib import Path

from scripts.documentation.pages import DOCS, ROOT

TIMEOUT = 600  # s, of a cell
STYLE = re.compile(r"<style[^>]*>.*?</style>", re.DOTALL)


def write_notebooks(folder: Path) -> None:
    """Run all notebooks and write each into ``folder`` as a page; the error of a cell ends it."""
    import nbformat
    from nbclient import NotebookClient
    from nbconvert.exporters import MarkdownExporter

    for path in sorted((DOCS / "notebooks").glob("*.ipynb")):
        notebook = nbformat.read(path, as_version=4)
        NotebookClient(notebook, timeout=TIMEOUT, resources={"metadata": {"path": str(ROOT)}}).execute()
        text, resources = MarkdownExporter().from_notebook_node(notebook, {"unique_key": path.stem})
        (folder / f"{path.stem}.md").write_text(STYLE.sub("", text), encoding="utf-8")
        for name, picture in resources.get("outputs", {}).items():
            (folder / name).write_bytes(picture)
