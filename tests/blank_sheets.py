"""Figures that nobody lays out or draws, for tests that look at none: half of what results cost to write."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TextIO

import numpy as np
import pytest


@contextmanager
def blank_sheets(*kinds: str) -> Iterator[None]:
    """Let every figure of matplotlib, curves and texts and all, be written as an empty sheet.

    ``kinds``: only as files of these, ".png" or ".svg", of which the latter are a page's; left out, as any.
    """
    from matplotlib.figure import Figure
    from matplotlib.image import imsave
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    drawn = Figure.savefig

    def written(figure: Figure, file: Path | TextIO, **options: Any) -> None:
        kind = file.suffix if isinstance(file, Path) else f".{options['format']}"
        width, height = 72 * figure.get_size_inches()
        if kinds and kind not in kinds:
            drawn(figure, file, **options)
        elif isinstance(file, Path) and kind != ".svg":
            imsave(file, np.ones((1, 1, 3)))
        else:
            sheet = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}"></svg>'
            file.write_text(sheet) if isinstance(file, Path) else file.write(sheet)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "savefig", written)
        if not kinds:
            patch.setattr(ConstrainedLayoutEngine, "execute", lambda engine, drawing: None)
        yield
